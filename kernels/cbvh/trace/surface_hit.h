// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A hit in a leaf of a block with frames as Embree's epilogues want it: parameters of the face, distance,
 * normal. */

#include "frame_ray.h"
#include "../codec/normal.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! what Embree's single-hit epilogues expect */
      struct SurfaceHit
      {
        float u, v, t;
        Vec3fa Ng;
        __forceinline void finalize () {}
      };

      /*! a hit in a leaf */
      struct LeafHit
      {
        float s;
        uint32_t leaf;
        float u, v;            //!< position in the leaf
        float slopeX, slopeY;  //!< of the surface there
        uint32_t from;         //!< side that the ray comes from, as far as it is known
      };

      /*! what a hit needs of its ray */
      struct HitSegment
      {
        vfloat4 P, D;               //!< in the frame
        float t0, t1, w0, w1;       //!< LocalRay
        Vec3fa dir;                 //!< RayPrecalculations
        float scale, rcpDir2;
        float enter, tfar;          //!< where the ray enters the block's bounds, and where it ended before anything was hit

        /*! t of s */
        __forceinline float worldT (float s) const { return madd(worldShare(w0,w1,s),t1-t0,t0)*scale; }

        /*! what is reported */
        __forceinline float inBounds (float t) const { return min(max(t,enter),tfar); }
      };

      class HitFrame
      {
      public:
        __forceinline HitFrame (const Block* block, const BlockLayout& layout)
          : block(block), leafSize(float(1u << block->height())/float(layout.leaves)) {}

        __forceinline SurfaceHit surfaceHit (const HitSegment& ray, const LeafHit& at, float t) const
        {
          SurfaceHit hit;
          hit.u = block->faceU(leafSize*(float(mortonX(at.leaf)) + at.u));
          hit.v = block->faceV(leafSize*(float(mortonY(at.leaf)) + at.v));
          hit.t = t;
          hit.Ng = unitNormal(madd(vfloat4(at.s),ray.D,ray.P),at.slopeX,at.slopeY);
          const float along = dot(hit.Ng,ray.dir);
          if (isTurned(along,1.0f,1.0f/ray.rcpDir2,at.from)) hit.Ng = hit.Ng - (2.0f*along*ray.rcpDir2)*ray.dir;
          return hit;
        }

      private:
        /*! worldNormal of codec/normal.h */
        __forceinline Vec3fa unitNormal (const vfloat4& P, float slopeX, float slopeY) const
        {
          const float k = P[2] - slopeX*P[0] - slopeY*P[1];
          const vfloat4 plane(-slopeX,-slopeY,1.0f,-k);
          const vfloat4 x = plane*vfloat4::load(block->columns[0]);
          const vfloat4 y = plane*vfloat4::load(block->columns[1]);
          const vfloat4 z = plane*vfloat4::load(block->columns[2]);
          const Vec3fa n(reduce_add(x),reduce_add(y),reduce_add(z));
          /* the frame of a block smaller than 1e-19 has components that have no square */
          return normalize_safe(n*(1.0f/max(reduce_max(abs(n)),1e-37f)));
        }

        const Block* block;
        const float leafSize; //!< in quads
      };
    }
  }
}
