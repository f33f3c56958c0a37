// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the visitors of the three kinds of leaves share: the ray in its block, and the way
 * to Embree's epilogues, so that masks and filters behave as for every other geometry. */

#include "block_walk1.h"
#include "../codec/normal.h"
#include "../../geometry/intersector_epilog.h"

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

      /*! runs the epilogue of closest hit or of any hit */
      __forceinline bool report (RayHit& ray, IntersectContext* context, uint32_t geomID, uint32_t primID, SurfaceHit& hit) {
        return Intersect1Epilog1<true>(ray,context,geomID,primID)(hit);
      }
      __forceinline bool report (Ray& ray, IntersectContext* context, uint32_t geomID, uint32_t primID, SurfaceHit& hit) {
        return Occluded1Epilog1<true>(ray,context,geomID,primID)(hit);
      }
      template<typename RayType> struct IsAnyHit;
      template<> struct IsAnyHit<Ray>    { static const bool value = true; };
      template<> struct IsAnyHit<RayHit> { static const bool value = false; };

      /*! a hit in a leaf */
      struct LeafHit
      {
        float s;
        uint32_t leaf;
        float u, v;            //!< position in the leaf
        float slopeX, slopeY;  //!< of the surface there
        uint32_t from;         //!< side that the ray comes from, as far as it is known
      };

      template<typename RayType>
      struct BlockVisitor1
      {
        RayType& ray;
        IntersectContext* context;
        const RayPrecalculations& pre;
        const Block* block;
        const BlockLayout& layout;
        const LocalRay& local;
        const FrameRay& frameRay;
        BlockTiles& tiles;
        float sBest;
        bool isHit;         //!< a hit was accepted

        __forceinline BlockVisitor1 (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block, const BlockLayout& layout,
                                     const LocalRay& local, const FrameRay& frameRay, BlockTiles& tiles)
          : ray(ray), context(context), pre(pre), block(block), layout(layout), local(local), frameRay(frameRay), tiles(tiles), sBest(1.0f), isHit(false) {}

        /* what BlockWalk1 asks for; only cLEAF has more */
        typedef NodeEntries::Tile LeafTile;
        static const uint32_t passedMask = 0u;
        __forceinline bool passedAbove (bool) { return false; }
        __forceinline LeafTile& leafTile (uint32_t m) { return tiles.tile(tiles.lastLevel(),m); }

        /*! whether the segment begins (ends) in the box of a leaf, at tnear (tfar) */
        __forceinline bool startsInside (const BoxRanges<16>& ranges, uint32_t leaf) const { return local.startClipped && ranges.sNear[leaf] < 0.0f; }
        __forceinline bool endsInside (const BoxRanges<16>& ranges, uint32_t leaf) const { return local.endClipped && ranges.sFar[leaf] > 1.0f; }

        /*! Reports a hit; true if it was accepted. */
        __forceinline bool reportHit (const LeafHit& at)
        {
          const float leafSize = float(1u << block->height())/float(layout.leaves); // in quads
          SurfaceHit hit;
          hit.u = block->faceU(leafSize*(float(mortonX(at.leaf)) + at.u));
          hit.v = block->faceV(leafSize*(float(mortonY(at.leaf)) + at.v));
          hit.t = min(max(local.worldT(pre,at.s),ray.tnear()),ray.tfar);
          hit.Ng = unitNormal(local.P0 + at.s*(local.P1-local.P0),at.slopeX,at.slopeY);
          const float along = dot(hit.Ng,pre.dir);
          if (isTurned(along,1.0f,1.0f/pre.rcpDir2,at.from)) hit.Ng = hit.Ng - (2.0f*along*pre.rcpDir2)*pre.dir;
          if (!report(ray,context,block->geomID,block->primID,hit)) return false;
          sBest = at.s;
          return isHit = true;
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
      };
    }
  }
}
