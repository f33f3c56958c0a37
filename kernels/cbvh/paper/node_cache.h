// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoded nodes of blocks with frames, in the cache of a thread (base/thread_cache.h). block_tiles.h fills it. A tile
 * contains the two levels below a node: four children and sixteen grandchildren. Grandchildren are decoded when a ray
 * first intersects their parent. */

#include "../base/thread_cache.h"
#include <cstdint>

namespace embree::cbvh {
/*! Planes of N boxes in the frame: [axis][0 lower, 1 upper][node]. */
template<int N>
struct alignas(64) NodePlanes {
  float planes[3][2][N];
};

/*! Surfaces of 16 leaves of cLEAF (leaf/format.h). */
struct LeafSurfaces {
  /*! Lower x and y of each leaf's box, and reciprocals of its extents in x and y. */
  alignas(64) float footprint[16][4];
  float height[16][4];     //!< z = [0] + u [1] + v [2] + u v [3] at (u,v) in the box
  float halfThickness[16]; //!< half the thickness of each leaf, in z
  uint32_t solid, empty;   //!< masks of leaves, see LeafPatch
};

class NodeEntries {
public:
  struct Tile {
    NodePlanes<16> grandchildren; //!< 4 c + i is child i of child c
    NodePlanes<4> children;
    const void* block; //!< null in an empty entry
    uint32_t number;   //!< number of the tile in its block, see BlockTiles
    uint32_t decoded;  //!< mask of children whose children are decoded
    uint32_t present;  //!< mask of grandchildren that exist: all, except in tiles above the root

    __forceinline bool isAboveRoot() const { return number == 0; }
  };

  struct LeafTile : public Tile {
    LeafSurfaces surfaces;
  };

  /*! Returns the tile's entry. If its `block` or `number` differs, the caller must decode the tile into it and set
   *  both. */
  __forceinline Tile& tile(const void* block, uint32_t number) { return tiles[hashOfTile(block, number) % numTiles]; }
  __forceinline LeafTile& leafTile(const void* block, uint32_t number) {
    return leafTiles[hashOfTile(block, number) % numLeafTiles];
  }

  void clear() {
    for (Tile& tile : tiles) tile.block = nullptr;
    for (LeafTile& tile : leafTiles) tile.block = nullptr;
  }

private:
  static const size_t numTiles = 64, numLeafTiles = 128;

  static __forceinline size_t hashOfTile(const void* block, uint32_t number) { return hashOfBlock(block) * 5 + number; }

  Tile tiles[numTiles];
  LeafTile leafTiles[numLeafTiles];
};

typedef ThreadCache<NodeEntries> NodeCache;
extern template class ThreadCache<NodeEntries>;
} // namespace embree::cbvh
