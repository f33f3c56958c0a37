// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Returns the decoded nodes of a block as tiles of two levels (node_cache.h), decoding them into the thread's cache if
 * necessary.
 *
 * The last tiles end with the leaves. If the number of levels is odd, the first tile's node is therefore above the
 * root, which is its only child. A root that is a leaf is the only grandchild.
 *
 * References are valid until the next call of tile() or leafTile(), or until a hit is reported, because a filter
 * function may trace further rays. */

#include "node_decoder4.h"
#include "block.h"
#include <cstring>

namespace embree::isa::cbvh {
class BlockTiles {
public:
  typedef NodeEntries::Tile Tile;
  typedef NodeEntries::LeafTile LeafTile;

  __forceinline BlockTiles(const Block* block, const BlockLayout& layout)
    : cache(NodeCache::ofThread()),
      block(block),
      nodeLevels(int(layout.nodeLevels)),
      heights((const char*)block + layout.leafOffset) {}

  /*! Level of the first tile's node: negative above the root. */
  __forceinline int firstLevel() const { return unlikely(nodeLevels == 0) ? -2 : -(nodeLevels & 1); }
  /*! Level of the last tiles' nodes. */
  __forceinline int lastLevel() const { return nodeLevels - 2; }

  /*! Returns the tile below node m (0 above the root) of a level, with decoded children. */
  __forceinline Tile& tile(int level, uint32_t m) {
    const uint32_t number = numberOf(level, m);
    Tile& tile = cache.tile(block, number);
    if (unlikely(tile.block != block || tile.number != number)) decodeChildren(tile, level, m);
    return tile;
  }

  /*! As above, for the last level of cLEAF. */
  __forceinline LeafTile& leafTile(uint32_t m) {
    const uint32_t number = numberOf(lastLevel(), m);
    LeafTile& tile = cache.leafTile(block, number);
    if (unlikely(tile.block != block || tile.number != number)) decodeChildren(tile, lastLevel(), m);
    return tile;
  }

  /*! True if the entry still contains tile `number` of this block and, for isDecoded(), the grandchild. */
  __forceinline bool isCached(const Tile& tile, uint32_t number) const {
    return tile.block == block && tile.number == number;
  }
  __forceinline bool isDecoded(const Tile& tile, uint32_t number, uint32_t grandchild) const {
    return isCached(tile, number) && (tile.decoded >> (grandchild >> 2)) & 1u;
  }

  /*! Decodes the grandchildren below the children in `mask` if necessary. */
  __forceinline void ensureDecoded(Tile& tile, uint32_t mask) {
    mask &= ~tile.decoded;
    if (unlikely(mask != 0)) decodeGrandchildren(tile, mask);
  }
  __forceinline void ensureDecoded(LeafTile& tile, uint32_t mask) {
    mask &= ~tile.decoded;
    if (unlikely(mask != 0)) decodeLeaves(tile, mask);
  }

private:
  /*! Number of a tile in its block: 0 above the root, otherwise 1 plus the index of its node's word. */
  static __forceinline uint32_t numberOf(int level, uint32_t m) {
    return level < 0 ? 0 : nodesOfLevels(uint32_t(level)) + m + 1;
  }

  /*! Index of the word of the tile's first child. */
  static __forceinline uint32_t firstChild(const Tile& tile) { return tile.number == 0 ? 0 : 4 * tile.number - 3; }

  __noinline void decodeChildren(Tile& tile, int level, uint32_t m) {
    if (level == firstLevel()) prefetchBlock();
    if (level >= 0) {
      const NodeBox box = boxOf(level, m); // may replace the tile in the same entry
      decodeNode(block->nodes()[nodesOfLevels(uint32_t(level)) + m], box, tile.children, 0);
    }
    tile.block = block;
    tile.number = numberOf(level, m);
    tile.decoded = 0;
    tile.present = level >= 0 ? 0xFFFFu : level == -1 ? 0xFu : 1u;
  }

  /*! Prefetches a block that was not visited recently: nothing hides the latency of its accesses, which depend on
   *  each other. Times 3: heights of cLEAF need at most twice as many bytes as header and nodes. */
  __forceinline void prefetchBlock() const {
    const size_t bytes = min(size_t(heights - (const char*)block) * 3, size_t(1024));
    for (size_t line = 64; line < bytes; line += 64) prefetchL1((const char*)block + line);
  }

  /*! For a root that is a leaf: the only grandchild of its tile. */
  static __forceinline void setRootBox(NodePlanes<16>& out) {
    for (int axis = 0; axis < 3; axis++) {
      vfloat4::store(out.planes[axis][0], vfloat4(zero));
      vfloat4::store(out.planes[axis][1], vfloat4(one));
    }
  }

  static __forceinline NodeBox boxOfChild(const Tile& tile, uint32_t c) {
    return unlikely(tile.isAboveRoot()) ? rootBox() : boxAt(tile.children, c);
  }

  /*! Box of node m, from the tile two levels above. */
  NodeBox boxOf(int level, uint32_t m) {
    if (level == 0) return rootBox();
    Tile& parent = tile(level - 2, m >> 4);
    ensureDecoded(parent, 1u << ((m & 15u) >> 2));
    return boxAt(parent.grandchildren, m & 15u);
  }

  __noinline void decodeGrandchildren(Tile& tile, uint32_t mask) {
    if (unlikely(nodeLevels == 0)) setRootBox(tile.grandchildren);
    else
      for (uint32_t rest = mask; rest; rest &= rest - 1) {
        const uint32_t c = uint32_t(bsf(rest));
        decodeNode(block->nodes()[firstChild(tile) + c], boxOfChild(tile, c), tile.grandchildren, 4 * c);
      }
    tile.decoded |= mask;
  }

  __noinline void decodeLeaves(LeafTile& tile, uint32_t mask) {
    const uint32_t firstGroup = firstChild(tile) - nodesOfLevels(uint32_t(nodeLevels - 1));
    for (uint32_t rest = mask; rest; rest &= rest - 1) {
      const uint32_t c = uint32_t(bsf(rest));
      uint64_t bits;
      memcpy(&bits, heights + 8 * size_t(firstGroup + c), 8);
      GroupDecoder4(tile.grandchildren, tile.surfaces, 4 * c)
          .decode(block->nodes()[firstChild(tile) + c], bits, boxOfChild(tile, c));
    }
    tile.decoded |= mask;
  }

  NodeCache& cache;
  const Block* block;
  const int nodeLevels;
  const char* heights;
};
} // namespace embree::isa::cbvh
