// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A block: 2^height x 2^height quads of a patch in one local frame. It is a
 * header, then the inner nodes of a complete quadtree level by level, each level
 * in Morton order, then the leaves in Morton order (cLEAF) or the vertices row
 * by row (cGRID). Nothing points anywhere: positions, parametrisation and vertex
 * indices follow from the index. FORMAT.md has the table of bytes.
 *
 * Only layout lives here; node_codec.h, leaf_codec.h and frame.h give the bytes
 * their meaning. */

#include "target.h"
#include <cstdint>
#include <cstddef>

namespace embree
{
  namespace cbvh { inline namespace CBVH_TARGET
  {
    enum class Kind : uint32_t { GRID = 0, VOXEL = 1, LEAF = 2 };

    static constexpr unsigned maxLevel = 8;

    /*! number of quadtree nodes in the first n levels */
    constexpr uint32_t nodesOfLevels(uint32_t n) { return ((1u << (2*n)) - 1)/3; }

    /*! spreads the lower 8 bits of x to the even bits */
    inline uint32_t spreadBits(uint32_t x) {
      x = (x | (x << 4)) & 0x0F0F;
      x = (x | (x << 2)) & 0x3333;
      return (x | (x << 1)) & 0x5555;
    }

    /*! inverse of spreadBits */
    inline uint32_t gatherBits(uint32_t x) {
      x &= 0x5555;
      x = (x | (x >> 1)) & 0x3333;
      x = (x | (x >> 2)) & 0x0F0F;
      return (x | (x >> 4)) & 0x00FF;
    }

    inline uint32_t morton(uint32_t x, uint32_t y) { return spreadBits(x) | (spreadBits(y) << 1); }
    inline uint32_t mortonX(uint32_t m) { return gatherBits(m); }
    inline uint32_t mortonY(uint32_t m) { return gatherBits(m >> 1); }

    /*! sizes and offsets in bytes of everything behind the header */
    struct BlockLayout
    {
      uint32_t nodeLevels;  //!< levels of inner nodes
      uint32_t nodes;
      uint32_t nodeOffset;
      uint32_t leafOffset;
      uint32_t leafBytes;
      uint32_t bytes;       //!< all, a multiple of 4

      static const uint32_t alignment = 16; //!< of a block in memory

      /*! distance between blocks that follow each other */
      uint32_t stride() const { return (bytes + alignment-1) & ~(alignment-1); }

      BlockLayout(Kind kind, uint32_t height);
    };

    /*! Header of a block. 76 bytes are 12 modulo 16 and a tree of nodes is 4 modulo 16, so
     *  that together they leave no gap in front of the next block. */
    struct Block
    {
      float centre[3];      //!< world position that the frame maps to (1/2,1/2,1/2)
      uint32_t geomID;
      float columns[3][4];  //!< frame: (X,Y,Z,W) = (1/2,1/2,1/2,1) + sum_i columns[i]*(p-centre)[i]
      uint32_t primID;
      uint32_t info;        //!< see the accessors
      uint8_t lastX, lastY; //!< position of the patch's last block: its number of blocks, less 1
      uint8_t u0, v0;       //!< face parameters of the patch's corner (0,0), in halves

      Kind kind() const { return Kind(info & 15); }
      uint32_t height() const { return (info >> 4) & 15; }
      uint32_t blockX() const { return (info >> 8) & 255; }   //!< position in the patch, in blocks
      uint32_t blockY() const { return (info >> 16) & 255; }

      /*! cLEAF: the edges on the border of the block are within this part of their leaves'
       *  boxes, from the outer side */
      float borderWidth() const { return float((info >> 28)+1)*(1.0f/16); }
      static uint32_t encodeBorderWidth(double width) {
        uint32_t code = 0;
        while (code < 15 && !(float(code+1)*(1.0f/16) >= width)) code++;
        return code << 28;
      }

      /*! quads of the patch along u and v */
      uint32_t quadsX() const { return (lastX+1u) << height(); }
      uint32_t quadsY() const { return (lastY+1u) << height(); }

      /*! Face parameters of a point, given in quads from the block's corner. Divided, not
       *  multiplied by a reciprocal, so that the patch ends at 1. */
      template<typename Float> Float faceU(const Float& x) const { return Float(0.5f*float(u0)) + (Float(float(blockX() << height())) + x)/Float(float(quadsX())); }
      template<typename Float> Float faceV(const Float& y) const { return Float(0.5f*float(v0)) + (Float(float(blockY() << height())) + y)/Float(float(quadsY())); }

      static uint32_t encodeInfo(Kind kind, uint32_t height, uint32_t x, uint32_t y) {
        return uint32_t(kind) | (height << 4) | (x << 8) | (y << 16);
      }

      BlockLayout layout() const { return BlockLayout(kind(),height()); }

      const uint32_t* nodes() const { return (const uint32_t*)(this+1); }
      const char* leaves() const { return (const char*)this + layout().leafOffset; }
      uint32_t* nodes() { return (uint32_t*)(this+1); }
      char* leaves() { return (char*)this + layout().leafOffset; }
    };
    static_assert(sizeof(Block) == 76, "block header is 76 bytes");
    static_assert(offsetof(Block,columns) == 16 && offsetof(Block,primID) == 64, "block header layout");

    inline BlockLayout::BlockLayout(Kind kind, uint32_t height)
    {
      const uint32_t quads = 1u << (2*height);
      const uint32_t width = (1u << height) + 1;
      nodeLevels = height;
      leafBytes = 0;
      switch (kind) {
      /* leaves are groups of 2 x 2 quads, as GRID's own. Vertices: x, y, z planes; 3 floats behind
       * are read by full-width loads of the last row */
      case Kind::GRID : nodeLevels = height ? height-1 : 0; leafBytes = 4*(3*width*width + 3); break;
      case Kind::VOXEL: break;
      /* groups of 2 x 2 as well, with a node's word each; one quad is cut into four */
      case Kind::LEAF : nodeLevels = height ? height : 1; leafBytes = height ? 2*quads : 8; break;
      }
      nodes = nodesOfLevels(nodeLevels);
      nodeOffset = sizeof(Block);
      leafOffset = nodeOffset + 4*nodes;
      bytes = leafOffset + leafBytes;
    }
  }}
}
