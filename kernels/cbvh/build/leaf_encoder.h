// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Leaves of cLEAF: groups of 2 x 2 cells. */

#include "block_geometry.h"
#include "group_encoder.h"
#include "leaf_thickness.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    class LeafEncoder
    {
    public:
      LeafEncoder(const BlockGeometry& geometry, Block* block, BlockStatistics& statistics)
        : geometry(geometry), block(block), groups((Heights*)block->leaves()), statistics(statistics) {}

      /*! writes the heights of group m, in this box, and returns its word */
      uint32_t group(uint32_t m, const NodeBox& box)
      {
        const EncodedGroup encoded = encodeGroup(box,quadsOf(m));
        groups[m] = encoded.heights;
        borderWidth = std::max(borderWidth,encoded.borderWidth);
        for (int c=0; c<4; c++)
          addLeaf(decodeLeaf(encoded.word,encoded.heights,c,box));
        return encoded.word;
      }

      void leaf(uint32_t, const NodeBox&) {}

      void finish() { block->info |= encodeBorderWidth(borderWidth); }

      /*! bits of the header for a border width: of the smallest code that is not less, or of the whole box */
      static uint32_t encodeBorderWidth(double width)
      {
        uint32_t code = 0;
        while (code < 15 && !(borderWidthOf(code << 28) >= width)) code++;
        return code << 28;
      }

    private:
      QuadGroup quadsOf(uint32_t m) const
      {
        QuadGroup group;
        const uint32_t side = (1u << geometry.cellLevels)+1, x = 2*mortonX(m), y = 2*mortonY(m);
        for (uint32_t v=0; v<9; v++)
          memcpy(group.vertices[v],geometry.local[(y+v/3)*side + x+v%3],sizeof(double[3]));
        for (uint32_t c=0; c<4; c++) group.boxes[c] = geometry.boxOf(geometry.cellLevels,4*m+c);
        memcpy(group.rounding,geometry.rounding,sizeof(group.rounding));
        group.border[0][0] = x == 0;
        group.border[1][0] = y == 0;
        group.border[0][1] = x+2 == side-1;
        group.border[1][1] = y+2 == side-1;
        return group;
      }

      void addLeaf(const LeafPatch& leaf)
      {
        if (leaf.empty) return;
        statistics.solidLeaves += leaf.solid;
        if (leaf.solid) { statistics.addBoxThickness(geometry,leaf.box); return; }
        const double slope[2] = { 0.5*(leaf.z[1]+leaf.z[3]-leaf.z[0]-leaf.z[2])/leaf.box.extent[0],
                                  0.5*(leaf.z[2]+leaf.z[3]-leaf.z[0]-leaf.z[1])/leaf.box.extent[1] };
        statistics.addThickness(geometry,leaf.box,slope,leaf.thickness);
      }

      const BlockGeometry& geometry;
      Block* block;
      Heights* groups;
      BlockStatistics& statistics;
      double borderWidth = 0;  //!< the largest of all groups
    };
  }}
}
