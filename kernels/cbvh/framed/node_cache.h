// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What each thread keeps of blocks with frames (thread_cache.h).
 *
 * A tile is a node with the two levels below it: its four children, and their sixteen children, which
 * traversal tests at once. The children of a child are decoded when a ray first meets that child. */

#include "../base/thread_cache.h"
#include <cstdint>

namespace embree
{
  namespace cbvh
  {
    /*! boxes of N nodes in the frame: [axis][0 lower, 1 upper][node] */
    template<int N>
    struct alignas(64) NodePlanes { float at[3][2][N]; };

    /*! the surfaces of leaves of cLEAF */
    struct LeafSurfaces
    {
      alignas(64) float footprint[16][4]; //!< of each leaf: lower x and y of its box, and the reciprocals of its extents there
      float height[16][4];            //!< z = [0] + u [1] + v [2] + u v [3], with u and v the position in the box
      float reach[16];                //!< half of the thickness, in z
      uint32_t solid, empty;          //!< masks of leaves
    };

    class NodeEntries
    {
    public:
      struct Tile
      {
        NodePlanes<16> grandchildren; //!< 4 c + i is child i of child c
        NodePlanes<4> children;
        const void* block;            //!< whose it is
        uint32_t number;              //!< of the tile in the block
        uint32_t decoded;             //!< children whose children are decoded, as a mask
        uint32_t present;             //!< grandchildren that there are, as a mask: all, but for tiles above the root

        __forceinline bool isAboveRoot () const { return number == 0; }
      };

      /*! grandchildren are leaves */
      struct LeafTile : public Tile
      {
        LeafSurfaces surfaces; //!< of those that are decoded
      };

      /*! The slot of a tile: what is there is the caller's if `block` and number say so, else it is to be
       *  filled, and named. */
      __forceinline Tile& tile (const void* block, uint32_t number) { return tiles[slot(block,number) % numTiles]; }
      __forceinline LeafTile& leafTile (const void* block, uint32_t number) { return leafTiles[slot(block,number) % numLeafTiles]; }

      void clear ()
      {
        for (Tile& tile : tiles) tile.block = nullptr;
        for (LeafTile& tile : leafTiles) tile.block = nullptr;
      }

    private:
      static const size_t numTiles = 64, numLeafTiles = 128;

      static __forceinline size_t slot (const void* block, uint32_t number) { return hashOfBlock(block)*5 + number; }

      Tile tiles[numTiles];
      LeafTile leafTiles[numLeafTiles];
    };

    typedef ThreadCache<NodeEntries> NodeCache;
  }
}
