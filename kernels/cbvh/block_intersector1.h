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

        __forceinline LeafGroup (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block,
                                 const LocalRay& local, const MirroredRay& mirrored, const char* data)
          : ray(ray), context(context), pre(pre), block(block), local(local), mirrored(mirrored), data(data), sBest(1.0f) {}

        __forceinline bool wantsPassed () const { return false; }
        __forceinline bool passedAbove (bool) { return false; }

        /*! index of a lane's child */
        __forceinline uint32_t child (uint32_t m, size_t lane) const { return 4*m + (uint32_t(lane) ^ uint32_t(mirrored.flipXY())); }

        /*! Reports a hit at s in a leaf; true if it was accepted. u, v: position in the
         *  leaf, slopeX, slopeY: of the surface there, all mirrored. */
        __forceinline bool reportHit (float s, uint32_t leaf, float u, float v, float slopeX, float slopeY)
        {
          const uint32_t height = block->height();
          const float rcpQuads = block->rcpQuads();
          const bool flipZ = mirrored.flip[2];
          if (mirrored.flip[0]) u = 1.0f-u;
          if (mirrored.flip[1]) v = 1.0f-v;
          if ((mirrored.flip[0] != 0) != flipZ) slopeX = -slopeX;
          if ((mirrored.flip[1] != 0) != flipZ) slopeY = -slopeY;
          const float x = float((block->blockX() << height) + mortonX(leaf)) + u;
          const float y = float((block->blockY() << height) + mortonY(leaf)) + v;

          SurfaceHit hit;
          hit.u = float(block->u0)*(8.0f/0x10000) + x*rcpQuads;
          hit.v = float(block->v0)*(8.0f/0x10000) + y*rcpQuads;
          hit.t = min(max(local.worldT(pre,s),ray.tnear()),ray.tfar);
          hit.Ng = worldNormal(block,local.P0 + s*(local.P1-local.P0),slopeX,slopeY);
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

      /*! cVOXEL: the ray hits a leaf where it enters its box. A ray that starts inside
       *  a box does not hit that box: it left, or was left behind by, that surface. */
      template<typename RayType>
      struct VoxelLeaf : public LeafGroup<RayType>
      {
        using LeafGroup<RayType>::LeafGroup;

        __forceinline bool leaves (const ChildBoxes& c, size_t hit, size_t, uint32_t m)
        {
          const MirroredRay& ray = this->mirrored;
          vboolf4 valid = laneMask(hit) & !startsInside(this->local,c);
          if (none(valid)) return false;
          const vfloat4 s = max(c.sNear,vfloat4(zero));
          const vfloat4 u = clamp((madd(s,ray.D[0],ray.P[0])-c.lower[0])/c.extent[0],vfloat4(zero),vfloat4(one));
          const vfloat4 v = clamp((madd(s,ray.D[1],ray.P[1])-c.lower[1])/c.extent[1],vfloat4(zero),vfloat4(one));
          while (any(valid))
          {
            const size_t i = select_min(valid,s);
            if (this->reportHit(s[i],this->child(m,i),u[i],v[i],0.0f,0.0f))
              return IsAnyHit<RayType>::value;
            clear(valid,i);
            valid &= s <= vfloat4(this->sBest);
          }
          return false;
        }
      };

      /*! cLEAF. The surface of a leaf is the bilinear patch through the middles of its
       *  intervals, and along a ray
       *
       *    f(s) = z of the ray - z of that patch,
       *
       *  taken where the ray enters and leaves the leaf's box and linear between (the
       *  paper's line test). Through the lower (upper) face of the box a ray passes
       *  below (above) the surface, whatever the patch says. The ray hits where f
       *  changes sign.
       *
       *  Patches of neighbouring leaves do not meet exactly, each is off the true
       *  surface by up to half a bin, and a ray could slip through the step between
       *  them. Therefore the ray remembers on which side it left the last leaf. It hits
       *
       *  - at the entry of a leaf, if it enters on the other side;
       *  - where it left a leaf within half a bin, if it then passes over (under) the
       *    boxes that come next, but was under (over) that leaf;
       *  - in a leaf at the border of the block, if within half a bin of its patch: its
       *    neighbour is in another block, which knows nothing of the ray's side.
       *
       *  Inside a block that is watertight because leaves, and boxes passed, cover the
       *  ray's way in x and y without a gap, so no change of side goes unseen. Between
       *  blocks it is because the true edge is inside the intervals of both leaves.
       *
       *  The paper takes every ray that meets an interval for a hit, at its near side.
       *  That closes the steps too, but thickens the surface: rays along a crest hit
       *  what they should pass, hits are early by half a bin, and rays that start on
       *  the surface hit it again. A segment that starts (ends) in a leaf, at tnear
       *  (tfar), hits it only if f changes sign. */
      template<typename RayType>
      struct HeightLeaf : public LeafGroup<RayType>
      {
        enum Side { UNKNOWN, BELOW, ABOVE };

        /*! of the leaf that the ray left last */
        Side side;
        bool pending;         //!< within half a bin of its surface
        float exitS, exitU, exitV, exitSlopeX, exitSlopeY;
        uint32_t exitLeaf;

        __forceinline HeightLeaf (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block,
                                  const LocalRay& local, const MirroredRay& mirrored, const char* data)
          : LeafGroup<RayType>(ray,context,pre,block,local,mirrored,data), side(UNKNOWN), pending(false) {}

        __forceinline bool wantsPassed () const { return pending; }

        __forceinline bool passedAbove (bool above)
        {
          const Side now = above ? ABOVE : BELOW;
          if (side == now) return false;
          side = now;
          pending = false;
          return this->reportHit(exitS,exitLeaf,exitU,exitV,exitSlopeX,exitSlopeY);
        }

        __forceinline bool onBorder (uint32_t leaf) const
        {
          const uint32_t last = (1u << this->block->height()) - 1;
          const uint32_t x = mortonX(leaf), y = mortonY(leaf);
          return x == 0 || y == 0 || x == last || y == last;
        }

        __forceinline bool leaves (const ChildBoxes& c, size_t hit, size_t passed, uint32_t m)
        {
          const MirroredRay& ray = this->mirrored;
          const LocalRay& local = this->local;

          /* 4 leaves x 4 heights, into lanes; lane l is child l ^ flip, and so are corners */
          const int flip = ray.flipXY();
          uint64_t bits;
          memcpy(&bits,this->data + 8*size_t(m),8);
          if (flip & 1) bits = ((bits >> 16) & 0x0000FFFF0000FFFFull) | ((bits & 0x0000FFFF0000FFFFull) << 16);
          if (flip & 2) bits = (bits >> 32) | (bits << 32);
          const vint4 leaf = vint4(_mm_unpacklo_epi16(_mm_cvtsi64_si128((long long)bits),_mm_setzero_si128()));
          const vint4 nibble(15);
          const vfloat4 q00 = vfloat4((leaf >> (4*(0^flip))) & nibble);
          const vfloat4 q10 = vfloat4((leaf >> (4*(1^flip))) & nibble);
          const vfloat4 q01 = vfloat4((leaf >> (4*(2^flip))) & nibble);
          const vfloat4 q11 = vfloat4((leaf >> (4*(3^flip))) & nibble);
          const size_t solid = movemask(vboolf4(leaf == vint4(solidLeaf)));
          const size_t empty = movemask(vboolf4(leaf == vint4(emptyLeaf)));

          /* z of the interval's middle = base + bin*(q+1/2), mirrored with z */
          const float zScale = decodeZScale(this->block->zScale()), binScale = zScale*(1.0f/heightBins);
          const vfloat4 halfBin = vfloat4(0.5f*binScale)*c.extent[2];
          const vfloat4 bin = vfloat4(ray.flip[2] ? -binScale : binScale)*c.extent[2];
          const vfloat4 base = madd(vfloat4(ray.flip[2] ? 0.5f*(zScale+1.0f) : 0.5f*(1.0f-zScale)),c.extent[2],c.lower[2]);

          const vfloat4 s0 = max(c.sNear,vfloat4(zero)), s1 = min(c.sFar,vfloat4(one));
          const vfloat4 rx = vfloat4(one)/c.extent[0], ry = vfloat4(one)/c.extent[1];
          auto boxU = [&](const vfloat4& s) { return clamp((madd(s,ray.D[0],ray.P[0])-c.lower[0])*rx,vfloat4(zero),vfloat4(one)); };
          auto boxV = [&](const vfloat4& s) { return clamp((madd(s,ray.D[1],ray.P[1])-c.lower[1])*ry,vfloat4(zero),vfloat4(one)); };
          const vfloat4 u0 = boxU(s0), v0 = boxV(s0), u1 = boxU(s1), v1 = boxV(s1);
          const vfloat4 a = q10-q00, b = q01-q00, twist = (q11-q01)-a;
          const vfloat4 half(0.5f);
          auto height = [&](const vfloat4& u, const vfloat4& v) { return madd(bin,madd(u,a,madd(v,madd(u,twist,b),q00+half)),base); };
          const vfloat4 f0 = madd(s0,ray.D[2],ray.P[2]) - height(u0,v0);
          const vfloat4 f1 = madd(s1,ray.D[2],ray.P[2]) - height(u1,v1);

          const vfloat4 reach = halfBin + vfloat4(ray.epsilonZ);
          /* through the lower (upper) face of a box a ray is below (above) the surface in it,
           * whatever the patch says; mirrored, it enters through lower and leaves through upper faces */
          const vfloat4 faceNear = (c.lower[2]-ray.Pnear[2])*ray.rcpD[2], faceFar = (c.lower[2]+c.extent[2]-ray.Pfar[2])*ray.rcpD[2];
          const vboolf4 below0 = (f0 < vfloat4(zero)) | ((faceNear >= c.sNear) & !startsInside(local,c));
          const vboolf4 above1m = (f1 >= vfloat4(zero)) | ((faceFar <= c.sFar) & !endsInside(local,c));
          const size_t flipAbove = ray.flip[2] ? 15 : 0;
          const size_t above0 = movemask(!below0) ^ flipAbove, above1 = movemask(above1m) ^ flipAbove;
          const size_t near = movemask(min(abs(f0),abs(f1)) <= reach);
          const size_t started = movemask(startsInside(local,c));
          const size_t clipped = started | movemask(endsInside(local,c));

          auto hitAt = [&](size_t i, float s) {
            const float u = clamp((ray.P[0][0]+s*ray.D[0][0]-c.lower[0][i])*rx[i],0.0f,1.0f);
            const float v = clamp((ray.P[1][0]+s*ray.D[1][0]-c.lower[1][i])*ry[i],0.0f,1.0f);
            const bool flat = (solid >> i) & 1;
            return this->reportHit(s,this->child(m,i),u,v,flat ? 0.0f : bin[i]*(a[i]+v*twist[i])*rx[i],flat ? 0.0f : bin[i]*(b[i]+u*twist[i])*ry[i]);
          };

          const ChildOrder order(c,hit | passed);
          size_t events = order.toOrder(hit | passed);
          while (events)
          {
            const size_t i = order.lane(bscf(events));
            const size_t bit = size_t(1) << i;
            if (!(hit & bit)) {
              if (pending && passedAbove(ray.isAbove(c,i))) return true;
              continue;
            }
            if ((solid | empty) & bit) {
              side = UNKNOWN; pending = false;
              if ((solid & bit) && !(started & bit) && hitAt(i,s0[i])) return true;
              continue;
            }
            const Side enter = above0 & bit ? ABOVE : BELOW, leave = above1 & bit ? ABOVE : BELOW;
            if (side != UNKNOWN && side != enter && !(started & bit) && hitAt(i,s0[i])) return true;
            if (enter != leave) {
              const float df = f0[i]-f1[i];
              const float k = df != 0.0f ? clamp(f0[i]/df,0.0f,1.0f) : 1.0f;
              if (hitAt(i,s0[i]+k*(s1[i]-s0[i]))) return true;
            }
            else if ((near & bit) && !(clipped & bit) && onBorder(this->child(m,i))) {
              if (hitAt(i,abs(f0[i]) < abs(f1[i]) ? s0[i] : s1[i])) return true;
            }
            side = leave;
            pending = near & bit;
            if (pending) {
              exitS = s1[i]; exitU = u1[i]; exitV = v1[i]; exitLeaf = this->child(m,i);
              exitSlopeX = bin[i]*(a[i]+v1[i]*twist[i])*rx[i];
              exitSlopeY = bin[i]*(b[i]+u1[i]*twist[i])*ry[i];
            }
          }
          return false;
        }
      };

      /*! cGRID: 2 x 2 quads of full-precision vertices, the very triangles and the very
       *  test of Embree's GRID */
      template<typename RayType>
      struct GridLeaf : public LeafGroup<RayType>
      {
        using LeafGroup<RayType>::LeafGroup;

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

        template<typename Loader>
        __forceinline bool quads (size_t width, size_t x, size_t y, size_t lines)
        {
          typedef typename Loader::vfloat vfloat;
          const size_t plane = width*width;
          const float* p = (const float*)this->data + y*width + x;
          Vec3<vfloat> v0, v1, v2;
          Loader::gather(p,p+plane,p+2*plane,width,lines,v0,v1,v2);
          const size_t height = this->block->height();
          return triangles<Loader>(this->ray,this->context,this->block,v0,v1,v2,
                                   float((size_t(this->block->blockX()) << height) + x),float((size_t(this->block->blockY()) << height) + y));
        }

        __forceinline bool leaves (const ChildBoxes& c, size_t hit, size_t, uint32_t m)
        {
          const size_t width = (size_t(1) << this->block->height()) + 1;
          const size_t lines = min(width,size_t(3));
          while (hit)
          {
            const size_t lane = bscf(hit);
            if (c.sNear[lane] > this->sBest) continue;
            const uint32_t g = this->child(m,lane);
            const size_t x = 2*mortonX(g), y = 2*mortonY(g);
            bool found;
#if defined(__AVX__)
            found = quads<GridSOA::Gather3x3>(width,x,y,lines);
#else
            found = quads<GridSOA::Gather2x3>(width,x,y,lines);
            if (IsAnyHit<RayType>::value && found) return true;
            if (lines > 2) found |= quads<GridSOA::Gather2x3>(width,x,y+1,lines);
#endif
            if (!found) continue;
            if (IsAnyHit<RayType>::value) return true;
            this->sBest = this->local.localS(this->pre,this->ray.tfar) + 1e-5f;
          }
          return false;
        }
      };

      template<template<typename> class Leaf>
      struct BlockIntersector1
      {
        /*! any hit: true if occluded; closest hit: what it returns has no meaning */
        template<typename RayType>
        static __forceinline bool intersect (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block)
        {
          LocalRay local;
          if (!local.init(pre,block,ray.tfar)) return false;
          const MirroredRay mirrored(local);
          const BlockLayout layout = block->layout();
          Leaf<RayType> group(ray,context,pre,block,local,mirrored,(const char*)block + layout.leafOffset);
          return traverseBlock(mirrored,block->nodes(),layout.nodeLevels,group);
        }
      };
    }
  }
}
