// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Format of a block of cGRID, cVOXEL or cLEAF: 2^height x 2^height quads of a patch in one local frame. A block
 * consists of a header, the words of a complete quadtree (level by level, each in Morton order), and the leaves in
 * Morton order (cLEAF) or the vertices row by row (cGRID). Positions and parameters follow from indices, so there are
 * no pointers. Memory, files and GPUs use the same bytes.
 *
 * README.md has the table of bytes; local_ray.h, node.h and leaf/format.h define their meaning.
 * Compiles as C++ and GLSL. */

#ifndef CBVH_PAPER_BLOCK_H
#define CBVH_PAPER_BLOCK_H

#include "../base/kinds.h"
#include "morton.h"

CBVH_BEGIN

/*! Increment it with changes that affect readers. */
CVERT_CONSTANT uint32_t formatVersion = 1u;

/*! True if words of the last node level are groups of leaves (leaf/format.h). */
CVERT_FUNCTION bool hasGroups(uint32_t kind) { return kindFormats[kind].bytesPerGroup != 0u; }

/* --- sizes --------------------------------------------------------------------------- */

CVERT_CONSTANT uint32_t blockHeaderBytes = 76u;

/*! Sizes and offsets of a block. */
struct BlockLayout {
  uint32_t nodeLevels;
  uint32_t leavesPerSide;
  uint32_t numNodes;   //!< number of node words
  uint32_t leafOffset; //!< in bytes from the start of the block
  uint32_t leafBytes;
  uint32_t bytes;  //!< of the block, a multiple of 4
  uint32_t stride; //!< bytes, rounded up to blockAlignment
};

CVERT_FUNCTION BlockLayout blockLayout(uint32_t kind, uint32_t height) {
  uint32_t leafLevels = kindFormats[kind].leafLevels;
  uint32_t width = (1u << height) + 1u;
  BlockLayout sizes;
  sizes.nodeLevels = height > leafLevels ? height - leafLevels : 0u;
  if (sizes.nodeLevels < kindFormats[kind].minNodeLevels) sizes.nodeLevels = kindFormats[kind].minNodeLevels;
  sizes.leavesPerSide = 1u << sizes.nodeLevels;
  sizes.numNodes = nodesOfLevels(sizes.nodeLevels);
  sizes.leafOffset = blockHeaderBytes + 4u * sizes.numNodes;
  sizes.leafBytes = kindFormats[kind].bytesPerGroup * sizes.leavesPerSide * sizes.leavesPerSide / 4u +
                    kindFormats[kind].bytesPerVertex * width * width + kindFormats[kind].tailPadding;
  sizes.bytes = sizes.leafOffset + sizes.leafBytes;
  sizes.stride = (sizes.bytes + blockAlignment - 1u) & ~(blockAlignment - 1u);
  return sizes;
}

/* --- header -------------------------------------------------------------------------- */

/*! 76 bytes, 12 modulo 16. A tree that is not empty has 4 modulo 16 bytes, so both together need no padding. */
struct BlockHeader {
  float center[3];     //!< world position that the frame maps to (1/2,1/2,1/2)
  uint32_t surface;    //!< number of the surface, see base/surface_ids.h
  float columns[3][4]; //!< frame: (X,Y,Z,W) = (1/2,1/2,1/2,1) + sum_i columns[i]*(p-center)[i]
  uint32_t primID;
  uint32_t info;   //!< bits 0..3: kind; 4..7: height; 8..15, 16..23: position; 28..31: see borderWidthOf
  uint32_t tiling; //!< bits 0..15: position of the patch's last block; 16..31: corner of the patch in its face
};

/*! x, y: position of the block in its patch, in blocks. */
CVERT_FUNCTION uint32_t blockInfo(uint32_t kind, uint32_t height, uint32_t x, uint32_t y) {
  return kind | (height << 4) | (x << 8) | (y << 16);
}
CVERT_FUNCTION uint32_t kindOf(uint32_t info) { return info & 15u; }
CVERT_FUNCTION uint32_t heightOf(uint32_t info) { return (info >> 4) & 15u; }
CVERT_FUNCTION uint32_t blockXOf(uint32_t info) { return (info >> 8) & 255u; }
CVERT_FUNCTION uint32_t blockYOf(uint32_t info) { return (info >> 16) & 255u; }

/*! cLEAF: width of lips (leaf/hit_rule.h). Edges of quads on the block's border are within this fraction of their
 *  leaves' boxes, measured from the outer side. */
CVERT_FUNCTION float borderWidthOf(uint32_t info) { return float((info >> 28) + 1u) * (1.0f / 16.0f); }

/*! lastX, lastY: position of the patch's last block. u0, v0: face parameters of the patch's corner (0,0), times 2. They
 *  differ from 0 only for patches of faces without four corners. */
CVERT_FUNCTION uint32_t blockTiling(uint32_t lastX, uint32_t lastY, uint32_t u0, uint32_t v0) {
  return lastX | (lastY << 8) | (u0 << 16) | (v0 << 24);
}
CVERT_FUNCTION uint32_t lastXOf(uint32_t tiling) { return tiling & 255u; }
CVERT_FUNCTION uint32_t lastYOf(uint32_t tiling) { return (tiling >> 8) & 255u; }
CVERT_FUNCTION uint32_t cornerUOf(uint32_t tiling) { return (tiling >> 16) & 255u; }
CVERT_FUNCTION uint32_t cornerVOf(uint32_t tiling) { return tiling >> 24; }

/* --- parameters ---------------------------------------------------------------------- */

/*! Face parameter, u or v, of a point x quads from the block's corner. corner: parameter of the patch's corner, times
 *  2. block, last: positions of the block and the patch's last block. Divides, because a product with a reciprocal is
 *  not always 1 at the patch's end. */
CVERT_REAL CVERT_FUNCTION Real faceParameter(uint32_t corner, uint32_t block, uint32_t last, uint32_t height, Real x) {
  return Real(0.5f * float(corner)) + (Real(float(block << height)) + x) / Real(float((last + 1u) << height));
}

CBVH_END

#ifndef VULKAN
#include <cstddef>

CBVH_BEGIN

/*! A block in memory; nodes and leaves follow the header. */
struct Block : public BlockHeader {
  Kind kind() const { return Kind(kindOf(info)); }
  uint32_t height() const { return heightOf(info); }
  BlockLayout layout() const { return blockLayout(kindOf(info), height()); }

  /*! Size of the patch, not the block. */
  uint32_t quadsX() const { return (lastXOf(tiling) + 1u) << height(); }
  uint32_t quadsY() const { return (lastYOf(tiling) + 1u) << height(); }

  /*! Face parameters of a point. x, y: in quads from the block's corner. */
  template<typename Float> Float faceU(const Float& x) const {
    return faceParameter(cornerUOf(tiling), blockXOf(info), lastXOf(tiling), height(), x);
  }
  template<typename Float> Float faceV(const Float& y) const {
    return faceParameter(cornerVOf(tiling), blockYOf(info), lastYOf(tiling), height(), y);
  }

  const uint32_t* nodes() const { return (const uint32_t*)(this + 1); }
  uint32_t* nodes() { return (uint32_t*)(this + 1); }
  const char* leaves() const { return (const char*)this + layout().leafOffset; }
  char* leaves() { return (char*)this + layout().leafOffset; }
};
static_assert(sizeof(Block) == blockHeaderBytes, "header of a block");
static_assert(offsetof(BlockHeader, columns) == 16 && offsetof(BlockHeader, primID) == 64 &&
                  offsetof(BlockHeader, tiling) == 72,
              "header of a block");

CBVH_END
#endif

#endif
