// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* vert_hits.h for the rays of a packet: those that pass inside of the edges of one triangle, as most do, together,
 * and the others, and where anything is not clear, one by one. */

#include "hits1.h"
#include "../framed/block_visitorK.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! what VertHits reports to */
      template<int K, typename Rays>
      struct VertTargetK
      {
        Rays& rays;
        IntersectContext* context;
        const size_t k;

        __forceinline float tnear () const { return rays.tnear()[k]; }
        __forceinline float tfar () const { return rays.tfar[k]; }
        __forceinline bool isRead (const VertHeader* block) const { return cbvh::isRead(rays,context,block->geomID); }
        __forceinline bool report (const VertHeader* block, SurfaceHit1& hit) const { return cbvh::report(rays,k,context,block->geomID,block->primID,hit); }
      };

      template<int K, typename Rays>
      class VertHitsK
      {
      public:
        __forceinline VertHitsK (Rays& rays, IntersectContext* context, VertRays<K>& pre, const VertHeader* block, const CachedVertBlock& cached)
          : rays(rays), context(context), pre(pre), block(block), cached(cached) {}

        /*! Those of some rays that accept a hit. triangles: of each ray; kz: of all */
        __forceinline uint32_t report (uint32_t mask, size_t kz, uint32_t g, const vint<K>& triangles)
        {
          uint32_t accepted = 0;
          const uint32_t one = mask & uint32_t(movemask((triangles & (triangles-vint<K>(1))) == vint<K>(zero)));
          if (popcnt(one) > 1 && likely(!VertParameters(block).isStitched()))
            mask &= ~together(one,kz,g,triangles,accepted);
          for (; mask; mask&=mask-1) {
            const uint32_t k = uint32_t(bsf(mask));
            if (report(k,g,uint32_t(triangles[k]))) accepted |= 1u << k;
          }
          return accepted;
        }

        /*! the same of one ray */
        __noinline bool report (size_t k, uint32_t g, uint32_t triangles)
        {
          typedef VertTargetK<K,Rays> Target;
          return VertHits<Target>(Target{ rays,context,k },pre.at(k),pre.nearest(k),block,cached).report(g,triangles);
        }

      private:
        /*! rays that each are in one triangle, their vertices by axis, and where the rays meet the planes */
        struct Triangles
        {
          alignas(64) float vertices[3][3][K];
          alignas(64) float x[K], y[K];  //!< quad of the patch
          alignas(64) float normal[3][K], t[K];
          uint32_t isMet; //!< not before tnear
          uint32_t lies;  //!< rays that lie in the plane

          __forceinline Triangles (uint32_t mask, const QuadCorners& quads, const vint<K>& triangles, float firstX, float firstY)
          {
            for (int k=0; k<3; k++)
              for (int i=0; i<3; i++) vfloat<K>::store(vertices[k][i],vfloat<K>(zero));
            vfloat<K>::store(x,vfloat<K>(firstX));
            vfloat<K>::store(y,vfloat<K>(firstY));
            for (; mask; mask&=mask-1)
            {
              const uint32_t ray = uint32_t(bsf(mask)), h = uint32_t(bsf(uint32_t(triangles[ray])));
              for (int i=0; i<3; i++) {
                const float (*corner)[16] = quads.at[cornerOfTriangle(h,i)];
                for (int k=0; k<3; k++) vertices[k][i][ray] = corner[k][h >> 1];
              }
              x[ray] += float((h >> 1) & 3);
              y[ray] += float(h >> 3);
            }
          }

          __forceinline void meet (const VertRays<K>& pre, size_t kz, const vfloat<K>& tnear)
          {
            isMet = lies = 0;
            for (int j=0; j<K; j+=4)
            {
              const Four four(*this,pre,j);
              const PlaneNormal<Double4> n = four.plane.normal();
              const PlaneMeeting<Double4> at = four.plane.meet(n,four.org,four.dir);
              const Double4 exact = four.plane.span(four.org,four.dir,kz).clamp(at.t);
              toFloat(exact).store(t+j);
              for (int k=0; k<3; k++) toFloat(n.at[k]).store(normal[k]+j);
              isMet |= (toDouble(lanesFrom(tnear,j)) <= exact).bits() << j;
              lies |= (15u & ~(at.least < magnitudeOf(at.speed)).bits()) << j;
            }
          }

          /*! rays whose triangles are between tnear and tfar as a whole */
          __forceinline uint32_t between (const VertRays<K>& pre, size_t kz, const vfloat<K>& tnear, const vfloat<K>& tfar) const
          {
            uint32_t mask = 0;
            for (int j=0; j<K; j+=4)
            {
              const Four four(*this,pre,j);
              const TriangleSpan<Double4> span = four.plane.span(four.org,four.dir,kz);
              mask |= ((toDouble(lanesFrom(tnear,j)) <= span.nearest) & (span.farthest < toDouble(lanesFrom(tfar,j)))).bits() << j;
            }
            return mask;
          }

        private:
          static __forceinline Float4 lanesFrom (const vfloat<K>& x, int j) { return Float4::load((const float*)&x + j); }

          struct Four
          {
            TrianglePlane<Float4,Double4> plane;
            Float4 org[3], dir[3];

            __forceinline Four (const Triangles& of, const VertRays<K>& pre, int j)
            {
              for (int k=0; k<3; k++) {
                for (int i=0; i<3; i++) plane.vertices[k][i] = Float4::load(of.vertices[k][i]+j);
                org[k] = lanesFrom(pre.org[k],j);
                dir[k] = lanesFrom(pre.dir[k],j);
              }
            }
          };
        };

        /*! Those that are done; others may be in the triangle or not, by the rounding of sides, lie in its plane, or have a
         *  hit at the very place already. */
        uint32_t together (uint32_t mask, size_t kz, uint32_t g, const vint<K>& triangles, uint32_t& accepted)
        {
          const VertParameters parameters(block);
          Triangles of(mask,cached.quads(g),triangles,float(parameters.firstX(g)),float(parameters.firstY(g)));
          const TriangleSides<vfloat<K>> sides = sidesOf(of,kz);
          const vfloat<K> tfar = rays.tfar;
          if (!isRead(rays,context,block->geomID))
          {
            const uint32_t clear = mask & uint32_t(movemask(sides.areCertain())) & of.between(pre,kz,rays.tnear(),tfar);
            const vfloat<K> unread(zero);
            const vbool<K> lanes = vbool<K>(int(clear));
            accepted |= uint32_t(movemask(lanes & cbvh::report(rays,lanes,context,block->geomID,block->primID,[&] { return std::make_tuple(unread,unread,unread,Vec3vf<K>(unread,unread,unread)); })));
            return clear;
          }
          of.meet(pre,kz,rays.tnear());
          const vfloat<K> t = vfloat<K>::load(of.t);
          const uint32_t done = mask & uint32_t(movemask(sides.areCertain() & (t != tfar))) & ~of.lies;
          const vbool<K> hit = vbool<K>(int(done & of.isMet)) & (t < tfar);
          if (none(hit)) return done;

          Vec3vf<K> Ng(vfloat<K>::load(of.normal[0]),vfloat<K>::load(of.normal[1]),vfloat<K>::load(of.normal[2]));
          const vbool<K> isLine = (Ng.x == vfloat<K>(zero)) & (Ng.y == vfloat<K>(zero)) & (Ng.z == vfloat<K>(zero));
          if (unlikely(any(hit & isLine))) Ng = select(isLine,Vec3vf<K>(-pre.dir[0],-pre.dir[1],-pre.dir[2]),Ng);
          vfloat<K> a, b, u, v;
          position(sides,triangles,a,b);
          parameters.template set<vfloat<K>>(vfloat<K>::load(of.x),vfloat<K>::load(of.y),a,b,u,v);
          const uint32_t of1 = uint32_t(movemask(hit & cbvh::report(rays,hit,context,block->geomID,block->primID,[&] { return std::make_tuple(u,v,t,Ng); })));
          for (uint32_t rest=of1; rest; rest&=rest-1) {
            const uint32_t k = uint32_t(bsf(rest));
            pre.nearest(k) = VertNearest(block,32*g+uint32_t(bsf(uint32_t(triangles[k]))),t[k]);
          }
          accepted |= of1;
          return done;
        }

        /*! VertTriangle::sides */
        __forceinline TriangleSides<vfloat<K>> sidesOf (const Triangles& of, size_t kz) const
        {
          const size_t kx = size_t(axisAfter(int(kz),1)), ky = size_t(axisAfter(int(kz),2));
          vfloat<K> x[3], y[3];
          for (int i=0; i<3; i++) {
            const vfloat<K> z = vfloat<K>::load(of.vertices[kz][i]) - pre.org[kz];
            x[i] = nmadd(pre.sx,z,vfloat<K>::load(of.vertices[kx][i]) - pre.org[kx]);
            y[i] = nmadd(pre.sy,z,vfloat<K>::load(of.vertices[ky][i]) - pre.org[ky]);
          }
          return TriangleSides<vfloat<K>>(x,y);
        }

        /*! VertTriangle::position */
        static __forceinline void position (const TriangleSides<vfloat<K>>& sides, const vint<K>& triangles, vfloat<K>& a, vfloat<K>& b)
        {
          const vbool<K> second = (triangles & vint<K>(int(0xAAAAAAAAu))) != vint<K>(zero);
          const vfloat<K> b1 = sides.b1(), b2 = sides.b2();
          a = select(second,b1+b2,b1);
          b = select(second,vfloat<K>(1.0f)-b1,b2);
        }

        Rays& rays;
        IntersectContext* context;
        VertRays<K>& pre;
        const VertHeader* block;
        const CachedVertBlock& cached;
      };
    }
  }
}
