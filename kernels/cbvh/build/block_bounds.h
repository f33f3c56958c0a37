// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Bounds in the world of all that a ray may hit in a block: its vertices, and the boxes of
 * its leaves, which reach past them. Where a leaf's box is what closes the surface, a ray
 * that is meant to be caught there must not be culled. */

#include "../codec/tree.h"
#include "block_geometry.h"

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    struct WorldBounds
    {
      double lower[3] = { 1e300,1e300,1e300 }, upper[3] = { -1e300,-1e300,-1e300 };

      void extend(const WorldBounds& other) {
        for (int k=0; k<3; k++) { lower[k] = minimum(lower[k],other.lower[k]); upper[k] = maximum(upper[k],other.upper[k]); }
      }
      void extend(double x, double y, double z) {
        const double p[3] = { x,y,z };
        for (int k=0; k<3; k++) { lower[k] = minimum(lower[k],p[k]); upper[k] = maximum(upper[k],p[k]); }
      }
      bool contains(const WorldBounds& other) const {
        bool inside = true;
        for (int k=0; k<3; k++) inside &= lower[k] <= other.lower[k] && other.upper[k] <= upper[k];
        return inside;
      }
    };

    /*! of a box in a frame: of its corners, as a projective map keeps it convex */
    inline WorldBounds boundBox(const NodeBox& box, const float centre[3], const InverseFrame& inverse)
    {
      WorldBounds bounds;
      for (int c=0; c<8; c++) {
        const Double3 p = inverse({ c & 1 ? upperOf(box,0) : box.lower[0], c & 2 ? upperOf(box,1) : box.lower[1], c & 4 ? upperOf(box,2) : box.lower[2] });
        bounds.extend(centre[0]+p.x,centre[1]+p.y,centre[2]+p.z);
      }
      return bounds;
    }

    class BlockBounds
    {
    public:
      BlockBounds(const Block* block, const BlockGeometry& geometry)
        : block(block), geometry(geometry), nodeLevels(block->layout().nodeLevels) {}

      WorldBounds compute()
      {
        for (uint32_t i=0; i<geometry.width*geometry.width; i++) {
          const float* p = geometry.vertices[i];
          if (geometry.isFinite(i)) bounds.extend(p[0],p[1],p[2]);
        }
        /* triangles between the vertices are within the bounds of these */
        if (block->kind() != Kind::GRID) extend(0,0,rootBox());
        return bounds;
      }

    private:
      /*! by the leaves below a node; none sticks out where its own box does not */
      void extend(uint32_t level, uint32_t m, const NodeBox& box)
      {
        const WorldBounds own = boundBox(box,block->centre,geometry.inverse);
        if (bounds.contains(own)) return;
        if (level == nodeLevels) { bounds.extend(own); return; }
        for (uint32_t c=0; c<4; c++)
        {
          if (level+1 == nodeLevels && geometry.boxOf(level+1,4*m+c).empty()) continue;
          extend(level+1,4*m+c,childBox(block,level,m,c,box));
        }
      }

      const Block* block;
      const BlockGeometry& geometry;
      uint32_t nodeLevels;
      WorldBounds bounds;
    };

    inline WorldBounds boundBlock(const Block* block, const BlockGeometry& geometry) { return BlockBounds(block,geometry).compute(); }
  }}
}
