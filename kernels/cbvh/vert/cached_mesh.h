// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* CachedVertBlock for mesh blocks. Shared code accesses the block as a VertHeader: `surface` and `primID` have the same
 * offsets in a MeshHeader. */

#include "../base/mapped_blocks.h"
#include "hits1.h"
#include "mesh_decoder.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      static_assert(offsetof(MeshHeader,surface) == offsetof(VertHeader,surface)
                    && offsetof(MeshHeader,primID) == offsetof(VertHeader,primID),
                    "surface and primID must have the same offsets in both headers");

      /*! Returns the primitive of a triangle, and parameters of a point. form: of the block. number: of the triangle.
       *  w1, w2: weights of its second and third corner. */
      __forceinline SurfacePoint pointOfMesh (uint32_t form, uint32_t number, float w1, float w2)
      {
        const bool isSecond = isSecondOfQuad(form,number);
        SurfacePoint point;
        point.primID = primitiveOfMesh(form,number);
        point.u = isSecond ? 1.0f-w1 : w1;
        point.v = isSecond ? 1.0f-w2 : w2;
        return point;
      }

      class CachedMeshBlock
      {
      public:
        template<typename VertRay>
        __forceinline CachedMeshBlock (const VertRay&, const VertHeader* block)
          : cache(MeshCache::ofThread()), block((const MeshHeader*)block), slot(cache.slot(block)),
            halves(cache.halves(block)) {}

        __forceinline const MeshBoxes* decodedBoxes () const { return likely(slot.block == block) ? &slot : nullptr; }

        /*! Always true: the block's bounds are its leaf's, which the ray hits. */
        __forceinline bool mayIntersect (const VertRayAxes<float>&, float, float) const { return true; }

        __forceinline bool isUsable () const { return cbvh::isUsable(block,MESH_FORM); }

        __forceinline const MeshBoxes& boxes () const
        {
          if (unlikely(slot.block != block)) decode();
          return slot;
        }

        /*! half: 0, or 1 if the group has a second half. */
        __forceinline const MeshTriangles& triangles (uint32_t g, uint32_t half) const
        {
          MeshTriangles& at = halves[16*half+g];
          if (at.key != keyOfHalf(block,16*half+g)) decode(g,half,at);
          return at;
        }

        __forceinline SurfacePoint point (uint32_t g, uint32_t t, float w1, float w2) const {
          return pointOfMesh(block->form,MeshDecoder(block).number(boxes(),g,t),w1,w2);
        }

      private:
        __noinline void decode () const
        {
          for (int line=1; line<16; line++) prefetchL1((const char*)block + 64*line);
          slot.block = block;
          MeshDecoder(block).decode(slot);
        }

        __noinline void decode (uint32_t g, uint32_t half, MeshTriangles& at) const
        {
          const MeshBoxes& boxes = this->boxes();
          at.key = keyOfHalf(block,16*half+g);
          MeshDecoder(block).triangles(boxes,g,half,at);
        }

        MeshCache& cache;
        const MeshHeader* block;
        MeshBoxes& slot;
        MeshTriangles* const halves;
      };

      /*! Cached: has triangles(), as CachedMeshBlock. */
      template<typename Cached>
      __forceinline VertTriangle triangleOfMesh (const Cached& cached, uint32_t g, uint32_t h) {
        return VertTriangle(cached.triangles(g,h >> 4),h & 15);
      }

      /*! GroupTriangles of a mesh block: of both halves of a group. */
      class MeshGroupTriangles
      {
      public:
        uint32_t mask; //!< bit h: triangle h

        /*! cached: has triangles(), as CachedMeshBlock. */
        template<typename Cached>
        __forceinline MeshGroupTriangles (const VertRay& ray, const Cached& cached, uint32_t g)
        {
          const MeshTriangles& first = cached.triangles(g,0);
          const bool isFirstOfTwo = first.isFirstOfTwo; // the second half may replace the first in its slot
          mask = trianglesHitByLine(ray,first,halves[0]);
          if (unlikely(isFirstOfTwo)) mask |= trianglesHitByLine(ray,cached.triangles(g,1),halves[1]) << 16;
        }

        /*! h: bit in mask */
        __forceinline TriangleSides<float> sides (uint32_t h) const { return halves[h >> 4].at(h & 15u); }

      private:
        SidesInLanes halves[2];
      };

      __forceinline VertTriangle triangleOf (const CachedMeshBlock& cached, uint32_t g, uint32_t h) {
        return triangleOfMesh(cached,g,h);
      }

      __forceinline MeshGroupTriangles groupTrianglesHitByLine (const VertRay& ray, const CachedMeshBlock& cached,
                                                                uint32_t g) {
        return MeshGroupTriangles(ray,cached,g);
      }

      __forceinline SurfacePoint pointOfHit (const CachedMeshBlock& cached, const VertHeader*, uint32_t g, uint32_t t,
                                             const VertTriangle::Sides& sides) {
        return cached.point(g,t,clampParameter(sides.w1/sides.sum),clampParameter(sides.w2/sides.sum));
      }
    }
  }
}
