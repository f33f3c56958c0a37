// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersector of blocks of cVERT: boxes of groups, groups front to back, their
 * triangles. Boxes only cull: their planes are exact, and are widened by what the test of
 * triangles may round, some ulps of the distance to the farthest plane. */

#include "block_visitor1.h"
#include "vert_triangles.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      template<typename RayType>
      class VertIntersector1
      {
      public:
        /*! whether a hit was accepted; any hit ends with it */
        static __forceinline bool intersect (RayType& ray, IntersectContext* context, VertRay& pre, const VertHeader* block)
        {
          pre.set(ray);
          return VertIntersector1(ray,context,pre,block).run();
        }

      private:
        __forceinline VertIntersector1 (RayType& ray, IntersectContext* context, const VertRay& pre, const VertHeader* block)
          : ray(ray), context(context), pre(pre), block(block) {}

        __forceinline bool run ()
        {
          VertCache& cache = VertCache::ofThread();
          VertCache::Block& boxes = cache.place(block);
          const bool isPacked = likely(!isRaw(block->boxForm));
          if (isPacked) sheared.set(pre,block);
          if (boxes.block != block) {
            if (isPacked && !meetsBlock()) return false;
            decode(boxes);
          }
          uint32_t open = meetBoxes(boxes);
          bool found = false;
          while (open)
          {
            const uint32_t g = nextGroup(open);
            if (enter[g] > ray.tfar) continue;
            const GroupTriangles triangles(pre,quadsOf(cache,g));
            if (triangles.mask == 0) continue;
            if (reportHits(cache,g,triangles)) {
              if (IsAnyHit<RayType>::value) return true;
              found = true;
            }
          }
          return found;
        }

        /* What the cache refers to lasts until a hit is reported: a filter may trace rays. */

        /*! corners and boxes of groups */
        __noinline void decode (VertCache::Block& at) const
        {
          /* The block at once, as long as most are: where its groups' fields lie is known late, and memory
           * that is waited for then is not hidden by anything. */
          for (int line=1; line<12; line++) prefetchL1((const char*)block + 64*line);
          at.block = block;
          const VertDecoder decoder(block);
          if (likely(!isRaw(block->boxForm))) decoder.corners(at.corners);
          decoder.planes(at.corners,at.planes);
        }

        /*! of the group in a lane */
        __forceinline const QuadCorners& quadsOf (VertCache& cache, uint32_t lane) const
        {
          VertCache::Group& at = cache.place(block,lane);
          if (at.block != block || at.lane != lane) decode(cache,lane,at);
          return at.quads;
        }

        __noinline void decode (VertCache& cache, uint32_t lane, VertCache::Group& at) const
        {
          VertCache::Block& boxes = cache.place(block);
          if (unlikely(boxes.block != block)) decode(boxes);
          at.block = block;
          at.lane = lane;
          VertDecoder(block).quads(boxes.corners,lane,at.quads);
        }

        /*! ulps that the sheared vertices, the boxes and the ray's distances to them may be off
         *  together: a difference is off by a half, a shear by three halves, a plane's distance
         *  by three, each of the two. */
        static constexpr float slackUlps = 8.0f;

        /*! the same of the sheared axis, where the ray's start and its direction are sums of three */
        static constexpr float shearedSlackUlps = 16.0f;

        /*! The ray along a block's sheared coordinate, from the block's origin. */
        struct ShearedRay
        {
          float org, rcp, error;

          __forceinline void set (const VertRay& ray, const VertHeader* block)
          {
            const int m = shearedAxis(block->boxForm);
            const float extent = extentOf(block);
            float dir = 0.0f, sum = 0.0f;
            org = 0.0f;
            for (int i=2; i>=0; i--)
            {
              const int k = m+i < 3 ? m+i : m+i-3;
              const float slope = i == 0 ? 1.0f : float(shearSlope(block->boxForm,i))*(1.0f/16.0f);
              const float distance = ray.org[k]-block->origin[k];
              org += slope*distance;
              dir += slope*ray.dir[k];
              sum += std::fabs(slope)*(std::fabs(distance) + extent);
            }
            rcp = VertRay::reciprocal(dir,ray.dir[ray.kz]);
            error = shearedSlackUlps*floatUlp*sum;
          }
        };

        /*! of a packed block from its origin, at least */
        static __forceinline float extentOf (const VertHeader* block) { return float(maxExtent)*vertSpacing(block->word); }

        __forceinline float slackOf (int k, float extent) const {
          return slackUlps*floatUlp*(std::fabs(block->origin[k]-pre.org[k]) + extent);
        }

        /*! Whether the ray meets the bounds of the block, which is not raw: most that do not meet a
         *  group do not, and nothing is decoded for them. */
        __forceinline bool meetsBlock ()
        {
          const int m = shearedAxis(block->boxForm);
          const float step = float(reachStep(block->boxForm))*vertSpacing(block->word), extent = extentOf(block);
          float tNear = ray.tnear(), tFar = ray.tfar;
          auto clip = [&](float lower, float upper, float rcp) {
            const float a = lower*rcp, b = upper*rcp;
            tNear = max(tNear,min(a,b));
            tFar = min(tFar,max(a,b));
          };
          for (int i=0; i<2; i++)
          {
            const int k = m+1+i < 3 ? m+1+i : m+1+i-3;
            const float from = block->origin[k]-pre.org[k], slack = slackOf(k,extent);
            clip(from-slack,(from + float(reachOf(block->reach,i))*step)+slack,pre.rcp[k]);
          }
          clip((float(reachOf(block->reach,2))*step-sheared.org)-sheared.error,(float(reachOf(block->reach,3))*step-sheared.org)+sheared.error,sheared.rcp);
          return tNear <= tFar;
        }

        /*! lanes of groups whose boxes the ray meets; sets enter */
        __forceinline uint32_t meetBoxes (const VertCache::Block& boxes)
        {
          const int vectors = CellCornersV::vectors;
          vfloatV tNear[vectors], tFar[vectors];
          for (int j=0; j<vectors; j++) { tNear[j] = vfloatV(ray.tnear()); tFar[j] = vfloatV(ray.tfar); }
          auto clip = [&](const GroupPlanes& planes, float from, float reciprocal, float error) {
            const float* near = reciprocal < 0.0f ? planes.upper : planes.lower;
            const float* far  = reciprocal < 0.0f ? planes.lower : planes.upper;
            const vfloatV org(from), rcp(reciprocal), slack(error*std::fabs(reciprocal));
            for (int j=0; j<vectors; j++) {
              tNear[j] = max(tNear[j],msub(vfloatV::load(near+vectorWidth*j) - org,rcp,slack));
              tFar [j] = min(tFar [j],madd(vfloatV::load(far +vectorWidth*j) - org,rcp,slack));
            }
          };
          const int m = isRaw(block->boxForm) ? 3 : shearedAxis(block->boxForm);
          for (int k=0; k<3; k++)
            if (k != m) clip(boxes.planes[k],pre.org[k],pre.rcp[k],slackOf(k,boxes.planes[k].extent));
          if (likely(m < 3)) clip(boxes.planes[m],sheared.org,sheared.rcp,sheared.error);
          uint32_t open = 0;
          for (int j=0; j<vectors; j++) {
            vfloatV::store(enter+vectorWidth*j,tNear[j]);
            open |= uint32_t(movemask(tNear[j] <= tFar[j])) << (vectorWidth*j);
          }
          return open & lanes();
        }

        /*! bits of lanes that have a group */
        __forceinline uint32_t lanes () const {
          return (((1u << groupsOf(vertQuadsX(block->place)))-1) * 0x1111u) & uint32_t((1u << (4*groupsOf(vertQuadsY(block->place))))-1);
        }

        /*! takes the group out that begins first */
        __forceinline uint32_t nextGroup (uint32_t& open) const
        {
          uint32_t best = uint32_t(bsf(open));
          for (uint32_t rest=open & (open-1); rest; rest&=rest-1) {
            const uint32_t g = uint32_t(bsf(rest));
            if (enter[g] < enter[best]) best = g;
          }
          open &= ~(1u << best);
          return best;
        }

        /*! Reports hits, nearest first; true if one was accepted. */
        __forceinline bool reportHits (VertCache& cache, uint32_t g, const GroupTriangles& triangles)
        {
          if (likely((triangles.mask & (triangles.mask-1)) == 0))
          {
            const uint32_t h = uint32_t(bsf(triangles.mask));
            const VertTriangle triangle(quadsOf(cache,g),h);
            const VertTriangle::Position position = triangle.position(pre,h);
            float t;
            return isMet(triangle,position,t) && reportHit(g,triangle,h,t,position);
          }
          return reportNearest(cache,g,triangles);
        }

        bool reportNearest (VertCache& cache, uint32_t g, const GroupTriangles& triangles)
        {
          float t[32];
          uint32_t open = 0;
          for (uint32_t rest=triangles.mask; rest; rest&=rest-1) {
            const uint32_t h = uint32_t(bsf(rest));
            const VertTriangle triangle(quadsOf(cache,g),h);
            if (isMet(triangle,triangle.position(pre,h),t[h])) open |= 1u << h;
          }
          while (open)
          {
            uint32_t best = uint32_t(bsf(open));
            for (uint32_t others=open & (open-1); others; others&=others-1) {
              const uint32_t h = uint32_t(bsf(others));
              if (t[h] < t[best]) best = h;
            }
            open &= ~(1u << best);
            const VertTriangle triangle(quadsOf(cache,g),best);
            if (reportHit(g,triangle,best,t[best],triangle.position(pre,best))) return true;
          }
          return false;
        }

        /*! sides that are not 0 have their exact sign already */
        __forceinline bool isMet (const VertTriangle& triangle, const VertTriangle::Position& position, float& t) const {
          return (likely(position.isCertain) || triangle.contains(pre)) && triangle.meet(ray,pre.kz,t);
        }

        __forceinline bool reportHit (uint32_t g, const VertTriangle& at, uint32_t h, float t, const VertTriangle::Position& position)
        {
          const uint32_t quad = h >> 1;
          SurfaceHit1 hit;
          hit.t = t;
          hit.Ng = at.Ng(ray);
          const uint32_t x = vertX(block->place) + groupQuads*(g & 3) + (quad & 3), y = vertY(block->place) + groupQuads*(g >> 2) + (quad >> 2);
          setParameters(x,y,h & 1,position.u,position.v,hit);
          return report(ray,context,block->geomID,block->primID,hit);
        }

        /*! Parameters of the face at position (a,b) of quad (x,y) of the patch: interpolated from
         *  those of the triangle's vertices, which Embree stitches where an edge has a lower rate. */
        __forceinline void setParameters (uint32_t x, uint32_t y, uint32_t triangle, float a, float b, SurfaceHit1& hit) const
        {
          const uint32_t quadsX = patchQuadsX(block->rates), quadsY = patchQuadsY(block->rates);
          a = inUnit(a);
          b = inUnit(b);
          float u = (float(x)+a)/float(quadsX), v = (float(y)+b)/float(quadsY);
          const bool stitched = vertRate(block->rates,0) != vertRate(block->rates,2) || vertRate(block->rates,1) != vertRate(block->rates,3);
          if (unlikely(stitched && (x == 0 || y == 0 || x+1 == quadsX || y+1 == quadsY)))
          {
            /* barycentrics of 00, 10, 01, 11 */
            const float w[4] = { triangle ? 0.0f : 1.0f-a-b, triangle ? 1.0f-b : a, triangle ? 1.0f-a : b, triangle ? a+b-1.0f : 0.0f };
            u = v = 0.0f;
            for (uint32_t c=0; c<4; c++) {
              const uint32_t i = x + (c & 1), j = y + (c >> 1);
              u += w[c]*vertParameter<float>(i,quadsX,j == 0 ? vertRate(block->rates,0) : j == quadsY ? vertRate(block->rates,2) : quadsX);
              v += w[c]*vertParameter<float>(j,quadsY,i == 0 ? vertRate(block->rates,3) : i == quadsX ? vertRate(block->rates,1) : quadsY);
            }
          }
          hit.u = 0.5f*float(vertCornerU(block->place)) + max(u,0.0f);
          hit.v = 0.5f*float(vertCornerV(block->place)) + max(v,0.0f);
        }

        /*! what is not a number, of slivers, becomes the middle of the diagonal: both triangles have it */
        static __forceinline float inUnit (float x) { return x >= 0.0f ? min(x,1.0f) : x < 0.0f ? 0.0f : 0.5f; }

        RayType& ray;
        IntersectContext* context;
        const VertRay& pre;
        const VertHeader* block;
        ShearedRay sheared;
        alignas(64) float enter[16]; //!< where the ray enters the box of the group in each lane
      };
    }
  }
}
