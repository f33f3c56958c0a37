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
          : rays(rays), context(context), pre(pre), block(block), layout(layout), frameRays(frameRays), tiles(tiles), sBest(1.0f), open(valid), isHit(false)
        {
          const vbool<K> nearer = valid & (rays.tfar < pre.tfar);
          if (any(nearer)) sBest = select(nearer,min(frameRays.behind(pre.rcpScale,rays.tfar),vfloat<K>(1.0f)),sBest);
        }

        /* what BlockWalkK asks for; only cLEAF has more */
        static const bool countsPassed = false;
        __forceinline vbool<K> wantsPassed () const { return vbool<K>(false); }
        __forceinline void pass (const vbool<K>&, const vbool<K>&) {}
        __forceinline LeafTile& leafTile (uint32_t m) { return tiles.tile(tiles.lastLevel(),m); }

        /*! whether segments begin (end) in the box of a leaf, at tnear (tfar) */
        __forceinline vbool<K> startInside (const BoxMeeting<K>& box) const { return frameRays.startClipped & (box.sNear < vfloat<K>(zero)); }
        __forceinline vbool<K> endInside (const BoxMeeting<K>& box) const { return frameRays.endClipped & (box.sFar > vfloat<K>(1.0f)); }

        /*! Reports hits of some lanes; those whose walks go on as after a hit (reportHit of block_visitor1.h). */
        __forceinline vbool<K> reportHits (const vbool<K>& lanes, uint32_t leaf, const LeafHits<K>& hits)
        {
          const uint32_t above = uint32_t(movemask(hits.fromAbove)), below = uint32_t(movemask(hits.fromBelow));
          uint32_t accepted = 0, refused = 0;
          for (uint32_t rest=uint32_t(movemask(lanes)); rest; rest&=rest-1)
          {
            const uint32_t k = uint32_t(bsf(rest));
            const HitSegment segment = segmentOf(k);
            const float tWorld = segment.worldT(hits.s[k]), t = segment.inBounds(tWorld);
            if (pre.nearest[k].isBehind(t,tWorld,block,rays.tfar[k])) continue;
            SurfaceHit hit = HitFrame(block,layout).surfaceHit(segment,hits.at(k,leaf,above,below),t);
            if (report(rays,k,context,block->geomID,block->primID,hit)) {
              pre.nearest[k].set(tWorld,block);
              accepted |= 1u << k;
            }
            else refused |= 1u << k;
          }
          accept(vbool<K>(int(accepted)));
          const vbool<K> counts = andn(lanes,vbool<K>(int(refused)));
          sBest = select(counts,hits.s,sBest);
          return counts;
        }

        __forceinline void accept (const vbool<K>& accepted)
        {
          isHit |= accepted;
          if (IsAnyHitK<Rays>::value) open = andn(open,accepted);
        }

      private:
        __forceinline HitSegment segmentOf (size_t k) const
        {
          const FrameRays<K>& f = frameRays;
          return HitSegment{ vfloat4(f.P[0][k],f.P[1][k],f.P[2][k],0.0f),vfloat4(f.D[0][k],f.D[1][k],f.D[2][k],0.0f),f.t0[k],f.t1[k],f.w0[k],f.w1[k],
                             Vec3fa(pre.dir.x[k],pre.dir.y[k],pre.dir.z[k]),pre.scale[k],pre.rcpDir2[k],max(rays.tnear()[k],pre.enter[k]),pre.tfar[k] };
        }
      };
    }
  }
}
