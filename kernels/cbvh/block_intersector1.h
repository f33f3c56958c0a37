// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersectors of blocks: closest hit and any hit, one class for each
 * kind of leaf. All of them share traverseBlock and differ in what they do with a
 * group of up to four leaves, and all report through Embree's epilogues, so masks
 * and filters behave as for every other geometry.
 *
 * Based on: Lier et al., "A High-Resolution Compression Scheme for Ray Tracing
 * Subdivision Surfaces with Displacement", 2018, section 4.2 (line test). */

#include "block_traverser1.h"
#include "leaf_codec.h"
#include "../geometry/grid_soa.h"
#include "../geometry/triangle_intersector_pluecker.h"
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
        return normalize_safe(Vec3fa(reduce_add(x),reduce_add(y),reduce_add(z)));
      }

      /*! hits of a group of leaves, before one of them is reported */
      struct GroupHits
      {
        vfloat4 s;          //!< segment parameter
        vfloat4 u, v;       //!< position in the leaf's box, mirrored
        vfloat4 slopeX, slopeY; //!< of the surface there, mirrored
      };

      /*! Reports hits of a group nearest first; true when traversal may end. */
      template<typename RayType>
      __forceinline bool reportGroup (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block,
                                      const LocalRay& local, const MirroredRay& mirrored, const uint32_t m,
                                      vboolf4 valid, const GroupHits& hits, float& sBest)
      {
        const uint32_t height = block->height();
        const float rcpQuads = block->rcpQuads();
        while (any(valid))
        {
          const size_t i = select_min(valid,hits.s);
          const float s = hits.s[i];
          const uint32_t leaf = 4*m + (uint32_t(i) ^ uint32_t(mirrored.flipXY()));
          const float u = mirrored.flip[0] ? 1.0f-hits.u[i] : hits.u[i];
          const float v = mirrored.flip[1] ? 1.0f-hits.v[i] : hits.v[i];
          const float x = float((block->blockX() << height) + mortonX(leaf)) + u;
          const float y = float((block->blockY() << height) + mortonY(leaf)) + v;
          const bool flipZ = mirrored.flip[2];
          const float slopeX = (mirrored.flip[0] != flipZ) ? -hits.slopeX[i] : hits.slopeX[i];
          const float slopeY = (mirrored.flip[1] != flipZ) ? -hits.slopeY[i] : hits.slopeY[i];

          SurfaceHit hit;
          hit.u = float(block->u0)*(8.0f/0x10000) + x*rcpQuads;
          hit.v = float(block->v0)*(8.0f/0x10000) + y*rcpQuads;
          hit.t = min(max(local.worldT(pre,s),ray.tnear()),ray.tfar);
          hit.Ng = worldNormal(block,local.P0 + s*(local.P1-local.P0),slopeX,slopeY);
          if (report(ray,context,block,hit)) {
            sBest = s;
            return IsAnyHit<RayType>::value;
          }
          clear(valid,i);
          valid &= hits.s <= vfloat4(sBest);
        }
        return false;
      }

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

      /*! cVOXEL: the ray hits a leaf where it enters its box. A ray that starts inside
       *  a box does not hit that box: it left, or was left behind by, that surface. */
      struct VoxelLeaf
      {
        template<typename RayType>
        static __forceinline bool intersect (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block,
                                             const LocalRay& local, const MirroredRay& mirrored, const char*,
                                             const ChildBoxes& c, size_t mask, uint32_t m, float& sBest)
        {
          const vboolf4 valid = laneMask(mask) & !startsInside(local,c);
          if (none(valid)) return false;
          GroupHits hits;
          hits.s = max(c.sNear,vfloat4(zero));
          hits.u = clamp((madd(hits.s,mirrored.D[0],mirrored.P[0])-c.lower[0])/c.extent[0],vfloat4(zero),vfloat4(one));
          hits.v = clamp((madd(hits.s,mirrored.D[1],mirrored.P[1])-c.lower[1])/c.extent[1],vfloat4(zero),vfloat4(one));
          hits.slopeX = hits.slopeY = vfloat4(zero);
          return reportGroup(ray,context,pre,block,local,mirrored,m,valid,hits,sBest);
        }
      };

      /*! cLEAF: one line test against the interval between the two bilinear patches.
       *
       *  f(s) = z of the ray - z of the interval's middle, taken at the entry and the
       *  exit of the box and linear between them (the paper's approximation). The ray
       *  misses if f is above half a bin at both ends, or below minus half at both.
       *  Otherwise it hits where f = 0, or at the end nearest to that. The set of rays
       *  that hit is the paper's; its three cases report the near side of the interval
       *  instead, which always hits half a bin early.
       *
       *  A segment that starts (ends) inside the box at tnear (tfar) hits only if f
       *  changes sign: the thickness is there to close the gaps between leaves, and
       *  a ray that starts on the surface must not hit it again. */
      struct HeightLeaf
      {
        template<typename RayType>
        static __forceinline bool intersect (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block,
                                             const LocalRay& local, const MirroredRay& mirrored, const char* leaves,
                                             const ChildBoxes& c, size_t mask, uint32_t m, float& sBest)
        {
          /* 4 leaves x 4 heights, into lanes; lane l is child l ^ flip, and so are corners */
          const int flip = mirrored.flipXY();
          uint64_t bits;
          memcpy(&bits,leaves + 8*size_t(m),8);
          if (flip & 1) bits = ((bits >> 16) & 0x0000FFFF0000FFFFull) | ((bits & 0x0000FFFF0000FFFFull) << 16);
          if (flip & 2) bits = (bits >> 32) | (bits << 32);
          const vint4 leaf = vint4(_mm_unpacklo_epi16(_mm_cvtsi64_si128((long long)bits),_mm_setzero_si128()));
          const vint4 nibble(15);
          const vfloat4 q00 = vfloat4((leaf >> (4*(0^flip))) & nibble);
          const vfloat4 q10 = vfloat4((leaf >> (4*(1^flip))) & nibble);
          const vfloat4 q01 = vfloat4((leaf >> (4*(2^flip))) & nibble);
          const vfloat4 q11 = vfloat4((leaf >> (4*(3^flip))) & nibble);
          const vboolf4 solid = vboolf4(leaf == vint4(solidLeaf));
          const vboolf4 empty = vboolf4(leaf == vint4(emptyLeaf));

          /* z of the interval's middle = base + bin*(q+1/2), mirrored with z */
          const float zScale = decodeZScale(block->zScale()), binScale = zScale*(1.0f/heightBins);
          const vfloat4 halfBin = vfloat4(0.5f*binScale)*c.extent[2];
          const vfloat4 bin = vfloat4(mirrored.flip[2] ? -binScale : binScale)*c.extent[2];
          const vfloat4 base = madd(vfloat4(mirrored.flip[2] ? 0.5f*(zScale+1.0f) : 0.5f*(1.0f-zScale)),c.extent[2],c.lower[2]);

          const vfloat4 s0 = max(c.sNear,vfloat4(zero)), s1 = min(c.sFar,vfloat4(one));
          const vfloat4 rx = vfloat4(one)/c.extent[0], ry = vfloat4(one)/c.extent[1];
          auto boxU = [&](const vfloat4& s) { return clamp((madd(s,mirrored.D[0],mirrored.P[0])-c.lower[0])*rx,vfloat4(zero),vfloat4(one)); };
          auto boxV = [&](const vfloat4& s) { return clamp((madd(s,mirrored.D[1],mirrored.P[1])-c.lower[1])*ry,vfloat4(zero),vfloat4(one)); };
          const vfloat4 u0 = boxU(s0), v0 = boxV(s0), u1 = boxU(s1), v1 = boxV(s1);
          const vfloat4 a = q10-q00, b = q01-q00, twist = (q11-q01)-a;
          const vfloat4 half(0.5f);
          auto height = [&](const vfloat4& u, const vfloat4& v) { return madd(bin,madd(u,a,madd(v,madd(u,twist,b),q00+half)),base); };
          const vfloat4 f0 = madd(s0,mirrored.D[2],mirrored.P[2]) - height(u0,v0);
          const vfloat4 f1 = madd(s1,mirrored.D[2],mirrored.P[2]) - height(u1,v1);

          const vfloat4 reach = halfBin + vfloat4(mirrored.epsilonZ);
          const vboolf4 start = startsInside(local,c);
          const vboolf4 clipped = start | endsInside(local,c);
          vboolf4 hit = (min(f0,f1) <= reach) & (max(f0,f1) >= -reach);
          hit &= !clipped | ((min(f0,f1) <= vfloat4(zero)) & (max(f0,f1) >= vfloat4(zero)));
          hit = (hit | solid) & !empty & !(solid & start);
          const vboolf4 valid = hit & laneMask(mask);
          if (none(valid)) return false;

          const vfloat4 df = f0-f1;
          const vfloat4 root = f0/select(df == vfloat4(zero),vfloat4(one),df);
          const vfloat4 k = select(solid,vfloat4(zero),clamp(root,vfloat4(zero),vfloat4(one)));
          GroupHits hits;
          hits.s = madd(k,s1-s0,s0);
          hits.u = boxU(hits.s);
          hits.v = boxV(hits.s);
          hits.slopeX = select(solid,vfloat4(zero),bin*madd(hits.v,twist,a)*rx);
          hits.slopeY = select(solid,vfloat4(zero),bin*madd(hits.u,twist,b)*ry);
          return reportGroup(ray,context,pre,block,local,mirrored,m,valid & (hits.s <= vfloat4(sBest)),hits,sBest);
        }
      };

      /*! cGRID: 2 x 2 quads of full-precision vertices, the very triangles and the very
       *  test of Embree's GRID */
      struct GridLeaf
      {
        /*! barycentrics of a triangle to parameters of the face, as GridSOA::MapUV does
         *  from stored parameters; lanes are ordered as its loaders order triangles */
        template<typename Loader>
        struct MapUV
        {
          typedef typename Loader::vfloat vfloat;
          vfloat x0, y0, x1, y1, x2, y2;

          __forceinline MapUV (const Block* block, float x, float y)
          {
            const float rcpQuads = block->rcpQuads();
            const float u = float(block->u0)*(8.0f/0x10000) + x*rcpQuads;
            const float v = float(block->v0)*(8.0f/0x10000) + y*rcpQuads;
            static const float X0[8] = {0,0,1,1,0,0,1,1}, Y0[8] = {0,1,0,1,1,2,1,2};
            static const float X1[8] = {1,1,2,2,1,1,2,2}, Y1[8] = {0,0,0,0,1,1,1,1};
            static const float X2[8] = {0,1,1,2,0,1,1,2}, Y2[8] = {1,1,1,1,2,2,2,2};
            auto place = [&](const float* d, float o) { return madd(vfloat::loadu(d),vfloat(rcpQuads),vfloat(o)); };
            x0 = place(X0,u); x1 = place(X1,u); x2 = place(X2,u);
            y0 = place(Y0,v); y1 = place(Y1,v); y2 = place(Y2,v);
          }

          __forceinline void operator() (vfloat& u, vfloat& v, Vec3<vfloat>& Ng) const
          {
            const vfloat w = vfloat(1.0f)-u-v;
            const vfloat x = u*x1 + v*x2 + w*x0;
            const vfloat y = u*y1 + v*y2 + w*y0;
            u = x; v = y;
          }
        };

        template<typename Loader>
        static __forceinline bool triangles (RayHit& ray, IntersectContext* context, const Block* block,
                                             const Vec3<typename Loader::vfloat>& v0, const Vec3<typename Loader::vfloat>& v1,
                                             const Vec3<typename Loader::vfloat>& v2, float x, float y)
        {
          const MapUV<Loader> mapUV(block,x,y);
          PlueckerIntersector1<Loader::M> intersector(ray,nullptr);
          return intersector.intersect(ray,v0,v1,v2,mapUV,Intersect1EpilogMU<Loader::M,true>(ray,context,block->geomID,block->primID));
        }

        template<typename Loader>
        static __forceinline bool triangles (Ray& ray, IntersectContext* context, const Block* block,
                                             const Vec3<typename Loader::vfloat>& v0, const Vec3<typename Loader::vfloat>& v1,
                                             const Vec3<typename Loader::vfloat>& v2, float x, float y)
        {
          const MapUV<Loader> mapUV(block,x,y);
          PlueckerIntersector1<Loader::M> intersector(ray,nullptr);
          return intersector.intersect(ray,v0,v1,v2,mapUV,Occluded1EpilogMU<Loader::M,true>(ray,context,block->geomID,block->primID));
        }

        template<typename Loader, typename RayType>
        static __forceinline bool quads (RayType& ray, IntersectContext* context, const Block* block, const float* vertices,
                                         size_t width, size_t x, size_t y, size_t lines, size_t blockX, size_t blockY)
        {
          typedef typename Loader::vfloat vfloat;
          const size_t plane = width*width;
          const float* p = vertices + y*width + x;
          Vec3<vfloat> v0, v1, v2;
          Loader::gather(p,p+plane,p+2*plane,width,lines,v0,v1,v2);
          return triangles<Loader>(ray,context,block,v0,v1,v2,float(blockX+x),float(blockY+y));
        }

        template<typename RayType>
        static __forceinline bool intersect (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block,
                                             const LocalRay& local, const MirroredRay& mirrored, const char* leaves,
                                             const ChildBoxes& c, size_t mask, uint32_t m, float& sBest)
        {
          const float* vertices = (const float*)leaves;
          const uint32_t height = block->height();
          const size_t width = (size_t(1) << height) + 1;
          const size_t lines = min(width,size_t(3));
          const size_t bx = size_t(block->blockX()) << height, by = size_t(block->blockY()) << height;
          while (mask)
          {
            const size_t lane = bscf(mask);
            if (c.sNear[lane] > sBest) continue;
            const uint32_t g = 4*m + (uint32_t(lane) ^ uint32_t(mirrored.flipXY()));
            const size_t x = 2*mortonX(g), y = 2*mortonY(g);
            bool hit;
#if defined(__AVX__)
            hit = quads<GridSOA::Gather3x3>(ray,context,block,vertices,width,x,y,lines,bx,by);
#else
            hit = quads<GridSOA::Gather2x3>(ray,context,block,vertices,width,x,y,lines,bx,by);
            if (IsAnyHit<RayType>::value && hit) return true;
            if (lines > 2) hit |= quads<GridSOA::Gather2x3>(ray,context,block,vertices,width,x,y+1,lines,bx,by);
#endif
            if (!hit) continue;
            if (IsAnyHit<RayType>::value) return true;
            sBest = local.localS(pre,ray.tfar) + 1e-5f;
          }
          return false;
        }
      };

      template<typename Leaf>
      struct BlockIntersector1
      {
        template<typename RayType>
        static __forceinline bool intersect (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block)
        {
          LocalRay local;
          if (!local.init(pre,block,ray.tfar)) return false;
          const MirroredRay mirrored(local);
          const BlockLayout layout = block->layout();
          const char* leaves = (const char*)block + layout.leafOffset;
          float sBest = 1.0f;
          return traverseBlock(mirrored,block->nodes(),layout.nodeLevels,sBest,[&](const ChildBoxes& c, size_t mask, uint32_t m) {
              return Leaf::intersect(ray,context,pre,block,local,mirrored,leaves,c,mask,m,sBest);
            });
        }
      };
    }
  }
}
