// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the visitors of the three kinds of leaves share for packets: the rays in their block, and the way to
 * Embree's epilogues, ray by ray. block_visitor1.h has the same for one ray. */

#include "block_walkK.h"
#include "surface_hit.h"
#include "../../geometry/intersector_epilog.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! runs the epilogue of closest hit or of any hit for a ray of a packet */
      template<int K>
      __forceinline bool report (RayHitK<K>& rays, size_t k, IntersectContext* context, uint32_t geomID, uint32_t primID, SurfaceHit& hit) {
        return Intersect1KEpilog1<K,true>(rays,k,context,geomID,primID)(hit);
      }
      template<int K>
      __forceinline bool report (RayK<K>& rays, size_t k, IntersectContext* context, uint32_t geomID, uint32_t primID, SurfaceHit& hit) {
        return Occluded1KEpilog1<K,true>(rays,k,context,geomID,primID)(hit);
      }
      template<typename Rays> struct IsAnyHitK;
      template<int K> struct IsAnyHitK<RayK<K>>    { static const bool value = true; };
      template<int K> struct IsAnyHitK<RayHitK<K>> { static const bool value = false; };

      /*! hits in a leaf, LeafHit */
      template<int K>
      struct LeafHits
      {
        vfloat<K> s, u, v, slopeX, slopeY;
        vbool<K> fromAbove, fromBelow;

        __forceinline LeafHit at (size_t k, uint32_t leaf, uint32_t above, uint32_t below) const {
          return LeafHit{ s[k],leaf,u[k],v[k],slopeX[k],slopeY[k],(above >> k) & 1u ? sideAbove : (below >> k) & 1u ? sideBelow : sideUnknown };
        }
      };

      template<int K, typename Rays>
      struct BlockVisitorK
      {
        typedef NodeEntries::Tile LeafTile;

        Rays& rays;
        IntersectContext* context;
        const RaysPrecalculations<K>& pre;
        const Block* block;
        const BlockLayout& layout;
        const FrameRays<K>& frameRays;
        BlockTiles& tiles;
        vfloat<K> sBest;
        vbool<K> open;   //!< rays that go on
        vbool<K> isHit;  //!< a hit was accepted

        __forceinline BlockVisitorK (Rays& rays, IntersectContext* context, const RaysPrecalculations<K>& pre, const Block* block, const BlockLayout& layout,
                                     const FrameRays<K>& frameRays, BlockTiles& tiles, const vbool<K>& valid)
          : rays(rays), context(context), pre(pre), block(block), layout(layout), frameRays(frameRays), tiles(tiles), sBest(1.0f), open(valid), isHit(false) {}

        /* what BlockWalkK asks for; only cLEAF has more */
        static const bool countsPassed = false;
        __forceinline vbool<K> wantsPassed () const { return vbool<K>(false); }
        __forceinline void pass (const vbool<K>&, const vbool<K>&) {}
        __forceinline LeafTile& leafTile (uint32_t m) { return tiles.tile(tiles.lastLevel(),m); }

        /*! whether segments begin (end) in the box of a leaf, at tnear (tfar) */
        __forceinline vbool<K> startInside (const BoxMeeting<K>& box) const { return frameRays.startClipped & (box.sNear < vfloat<K>(zero)); }
        __forceinline vbool<K> endInside (const BoxMeeting<K>& box) const { return frameRays.endClipped & (box.sFar > vfloat<K>(1.0f)); }

        /*! Reports hits of some lanes; those that were accepted. */
        __forceinline vbool<K> reportHits (const vbool<K>& lanes, uint32_t leaf, const LeafHits<K>& hits)
        {
          const uint32_t above = uint32_t(movemask(hits.fromAbove)), below = uint32_t(movemask(hits.fromBelow));
          uint32_t accepted = 0;
          for (uint32_t rest=uint32_t(movemask(lanes)); rest; rest&=rest-1) {
            const uint32_t k = uint32_t(bsf(rest));
            if (reportHit(k,hits.at(k,leaf,above,below))) accepted |= 1u << k;
          }
          return accept(vbool<K>(int(accepted)),hits.s);
        }

        /*! those that were accepted, at s or before */
        __forceinline vbool<K> accept (const vbool<K>& accepted, const vfloat<K>& s)
        {
          sBest = select(accepted,s,sBest);
          isHit |= accepted;
          if (IsAnyHitK<Rays>::value) open = andn(open,accepted);
          return accepted;
        }

      private:
        __noinline bool reportHit (size_t k, const LeafHit& at)
        {
          const FrameRays<K>& f = frameRays;
          const HitSegment segment = { vfloat4(f.P[0][k],f.P[1][k],f.P[2][k],0.0f),vfloat4(f.D[0][k],f.D[1][k],f.D[2][k],0.0f),f.t0[k],f.t1[k],f.w0[k],f.w1[k],
                                       Vec3fa(pre.dir.x[k],pre.dir.y[k],pre.dir.z[k]),pre.scale[k],pre.rcpDir2[k],rays.tnear()[k],rays.tfar[k] };
          SurfaceHit hit = HitFrame(block,layout).surfaceHit(segment,at);
          return report(rays,k,context,block->geomID,block->primID,hit);
        }
      };
    }
  }
}
