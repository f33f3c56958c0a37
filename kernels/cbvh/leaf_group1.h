// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the intersectors of the three kinds of leaves share: the ray in its block,
 * and the way to Embree's epilogues, so that masks and filters behave as for every
 * other geometry. */

#include "block_traverser1.h"
#include "../geometry/intersector_epilog.h"

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
        __forceinline void finalize() {}
      };

      /*! runs the epilogue of closest hit or of any hit */
      __forceinline bool report (RayHit& ray, IntersectContext* context, const Block* block, SurfaceHit& hit) {
        return Intersect1Epilog1<true>(ray,context,block->geomID,block->primID)(hit);
      }
      __forceinline bool report (Ray& ray, IntersectContext* context, const Block* block, SurfaceHit& hit) {
        return Occluded1Epilog1<true>(ray,context,block->geomID,block->primID)(hit);
      }
      template<typename RayType> struct IsAnyHit;
      template<> struct IsAnyHit<Ray>    { static const bool value = true; };
      template<> struct IsAnyHit<RayHit> { static const bool value = false; };

      /*! World normal of the plane z = slopeX x + slopeY y + const through P of the
       *  frame. A plane (a,b,c,d) of homogeneous frame coordinates is the plane
       *  (a,b,c,d) M of the world: no inverse is needed. */
      __forceinline Vec3fa worldNormal (const Block* block, const vfloat4& P, float slopeX, float slopeY)
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

      /*! what the three kinds of leaves share: a ray in a block */
      template<typename RayType>
      struct LeafGroup
      {
        RayType& ray;
        IntersectContext* context;
        const RayPrecalculations& pre;
        const Block* block;
        const LocalRay& local;
        const MirroredRay& mirrored;
        const char* data; //!< leaves
        float sBest;
        float leafSize; //!< of a leaf's side, in quads

        __forceinline LeafGroup (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block,
                                 const LocalRay& local, const MirroredRay& mirrored, const char* data)
          : ray(ray), context(context), pre(pre), block(block), local(local), mirrored(mirrored), data(data), sBest(1.0f), leafSize(1.0f) {}

        __forceinline bool wantsPassed () const { return false; }
        __forceinline bool passedAbove (bool) { return false; }

        __forceinline void decode (uint32_t word, uint32_t, const vfloat4 lower[3], const vfloat4 extent[3], ChildBoxes& c) const {
          mirrored.decode(word,lower,extent,c);
        }

        /*! index of a lane's child */
        __forceinline uint32_t child (uint32_t m, size_t lane) const { return 4*m + (uint32_t(lane) ^ uint32_t(mirrored.flipXY())); }

        /*! Reports a hit at s in a leaf; true if it was accepted. u, v: position in the
         *  leaf, slopeX, slopeY: of the surface there, all mirrored. from: 1 if the ray comes
         *  from above in the frame, -1 from below, 0 if that is not known. Where it meets a
         *  step behind a silhouette the surface faces away, by less than 30 degrees: then the
         *  normal is mirrored across the ray, which came from the other side. */
        __forceinline bool reportHit (float s, uint32_t leaf, float u, float v, float slopeX, float slopeY, float from = 0.0f)
        {
          const bool flipZ = mirrored.flip[2];
          if (mirrored.flip[0]) u = 1.0f-u;
          if (mirrored.flip[1]) v = 1.0f-v;
          if ((mirrored.flip[0] != 0) != flipZ) slopeX = -slopeX;
          if ((mirrored.flip[1] != 0) != flipZ) slopeY = -slopeY;

          SurfaceHit hit;
          hit.u = block->faceU(leafSize*(float(mortonX(leaf)) + u));
          hit.v = block->faceV(leafSize*(float(mortonY(leaf)) + v));
          hit.t = min(max(local.worldT(pre,s),ray.tnear()),ray.tfar);
          hit.Ng = worldNormal(block,local.P0 + s*(local.P1-local.P0),slopeX,slopeY);
          const float away = dot(hit.Ng,pre.dir);
          if (away*from > 0.0f && away*away*pre.rcpDir2 < 0.25f) hit.Ng = hit.Ng - (2.0f*away*pre.rcpDir2)*pre.dir;
          if (!report(ray,context,block,hit)) return false;
          sBest = s;
          return true;
        }
      };

      /*! lanes whose segment begins or ends inside the leaf's box, at tnear or tfar */
      __forceinline vboolf4 startsInside (const LocalRay& local, const ChildBoxes& c) {
        return vboolf4(local.startClipped) & (c.sNear < vfloat4(zero));
      }

      __forceinline vboolf4 endsInside (const LocalRay& local, const ChildBoxes& c) {
        return vboolf4(local.endClipped) & (c.sFar > vfloat4(1.0f));
      }

      __forceinline vboolf4 laneMask (size_t mask) {
        return (vint4(int(mask)) & vint4(1,2,4,8)) != vint4(zero);
      }
    }
  }
}
