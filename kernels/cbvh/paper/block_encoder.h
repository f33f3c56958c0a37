// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes a block: fits a frame (frame_fit.h), then encodes nodes top-down, each relative to the decoded box of its
 * parent, so that rounding errors cannot accumulate.
 *
 * Encoders of leaves, one per kind, have these members. m is an index in Morton order. Boxes are decoded.
 *
 *    uint32_t encodeGroup (uint32_t m, const NodeBox& box)
 *      Encodes a group of the last node level, for kinds that have groups. Returns its word.
 *    void encodeSiblingGroups (uint32_t m, const NodeBoxes& boxes, uint32_t words[4])
 *      Encodes groups m to m+3, the children of one node, and stores their words.
 *    void encodeLeaf (uint32_t m, const NodeBox& box)
 *      Encodes a leaf, for kinds without groups.
 *    void finish ()
 *      Called once, after all leaves. */

#include "block_bounds.h"
#include "grid/encoder.h"
#include "leaf/encoder.h"
#include "voxel/encoder.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
class BlockEncoder {
public:
  /*! Arguments: see BlockGeometry. fit() must return true before encode() is called. */
  BlockEncoder(Kind kind, uint32_t height, const float (*vertices)[3], void* scratch)
    : kind(kind),
      geometry(kind, height, vertices, scratch) {}

  static size_t scratchBytes(uint32_t height) { return BlockGeometry::scratchBytes(height); }
  bool fit(const float corners[4][3]) { return geometry.fit(corners); }
  bool isDegenerate() const { return geometry.isDegenerate(); }

  /*! Writes frame, info, nodes and leaves. The caller must set surface, primID and tiling. block:
   *  blockLayout(kind,height).bytes bytes, aligned to 16 bytes. x, y: position in the patch, in blocks. sharpSides:
   *  mask of the block's sides (surface/source.h) where the surface ends or bends (sharpSidesOf()), for statistics.
   *  Sets statistics.affine, and adds to the other members. */
  void encode(Block* block, uint32_t x, uint32_t y, BlockStatistics& statistics, uint32_t sharpSides = 0) {
    block->info = blockInfo(uint32_t(kind), geometry.height, x, y);
    memcpy(block->center, geometry.frame.center, sizeof(block->center));
    memcpy(block->columns, geometry.frame.columns, sizeof(block->columns));
    geometry.computeBounds();
    statistics.affine = !geometry.frame.projective;
    statistics.invalidQuads += geometry.invalidQuads;
    switch (kind) {
    case Kind::CGRID: encodeWith(GridEncoder(geometry, block, statistics), block); break;
    case Kind::CVOXEL: encodeWith(VoxelEncoder(geometry, block, statistics), block); break;
    case Kind::CLEAF: encodeWith(LeafEncoder(geometry, block, sharpSides, statistics), block); break;
    case Kind::CVERT:
    case Kind::CTILE: break; // have no frame: cvert/encoder
    }
  }

  /* See block_bounds.h. Require encode(). */
  WorldBounds surfaceBounds() const { return boundSurface(geometry); }
  void extendByHits(WorldBounds& bounds, const Block* block) const { HitBounds(bounds, block, geometry).extend(); }

private:
  template<typename Encoder>
  void encodeWith(Encoder encoder, Block* block) {
    encodeSubtree(encoder, block->nodes(), block->layout().nodeLevels, 0, 0, rootBox());
    encoder.finish();
  }

  /*! Encodes node m of a level, and everything below. nodes: words of the block. box: decoded box of the node. */
  template<typename Encoder>
  void encodeSubtree(Encoder& encoder, uint32_t* nodes, uint32_t nodeLevels, uint32_t level, uint32_t m,
                     const NodeBox& box) {
    if (level == nodeLevels) {
      encoder.encodeLeaf(m, box);
      return;
    }
    uint32_t& word = nodes[nodesOfLevels(level) + m];
    if (level + 1 == nodeLevels && hasGroups(uint32_t(kind))) {
      word = encoder.encodeGroup(m, box);
      return;
    }
    word = encodeNode(box, &geometry.boxOf(level + 1, 4 * m));
    const NodeBoxes boxes(word, box);
    if (level + 2 == nodeLevels && hasGroups(uint32_t(kind))) {
      encoder.encodeSiblingGroups(4 * m, boxes, nodes + nodesOfLevels(level + 1) + 4 * m);
      return;
    }
    for (uint32_t c = 0; c < 4; c++) encodeSubtree(encoder, nodes, nodeLevels, level + 1, 4 * m + c, boxes[c]);
  }

  Kind kind;
  BlockGeometry geometry;
};
}} // namespace embree::cbvh::CBVH_ISA
