// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Leaves of cLEAF: patches of four heights.
 *
 * The surface of a leaf is the bilinear patch through the middles of its intervals,
 * and along a ray
 *
 *   f(s) = z of the ray - z of that patch,
 *
 * taken where the ray enters and leaves the leaf's box (the paper's line test; its
 * root is that of the patch, not of the line). Through the lower (upper) face of the
 * box a ray passes below (above) the surface, whatever the patch says. The ray hits
 * where f changes sign.
 *
 * Patches of neighbouring leaves do not meet exactly, each is off the true surface by
 * up to half a bin, and a ray could slip through the step between them. Therefore the
 * ray remembers on which side it left the last leaf. It hits
 *
 * - at the entry of a leaf, if it enters on the other side;
 * - where it left a leaf within half a bin, if it then passes over (under) the boxes
 *   that come next, but was under (over) that leaf;
 * - in a leaf at the border of the block, if within half a bin of its patch: its
 *   neighbour is in another block, which knows nothing of the ray's side.
 *
 * Inside a block that is watertight because leaves, and boxes passed, cover the ray's
 * way in x and y without a gap, so no change of side goes unseen. Between blocks it is
 * because the true edge is inside the intervals of both leaves.
 *
 * A ray that starts on the surface of a leaf, within half a bin, does not hit a step
 * that it is beyond again when it leaves the step's leaf: it would shadow the surface
 * it comes from. A segment that starts (ends) in a leaf, at tnear (tfar), hits it only
 * if f changes sign.
 *
 * The paper takes every ray that meets an interval for a hit, at its near side. That
 * closes the steps too, but thickens the surface: rays along a crest hit what they
 * should pass, hits are early by half a bin, and rays that start on the surface hit it
 * again.
 *
 * Where a surface folds over, leaves overlap and the walk's order is not the ray's:
 * a closest-hit walk goes on after a hit, and takes nearer changes of sign.
 *
 * Based on: Lier et al., "A High-Resolution Compression Scheme for Ray Tracing
 * Subdivision Surfaces with Displacement", 2018, section 4. */

#include "leaf_group1.h"
#include "leaf_codec.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! the patches of up to four leaves, mirrored with the ray; lane l is child l ^ flip */
      struct HeightPatches
      {
        vfloat4 base;          //!< z at height 0, bins' middles
        vfloat4 bin;           //!< negative where z is mirrored
        vfloat4 q, a, b, twist; //!< height = q + a u + b v + twist u v, in bins
        vfloat4 rcpX, rcpY;    //!< of the box's extents
        size_t solid, empty;

        __forceinline HeightPatches (const char* leaves, uint32_t m, float zScale, const MirroredRay& ray, const ChildBoxes& c)
        {
          /* 4 leaves x 4 heights of 4 bits; mirroring x (y) swaps columns (rows) of leaves, and
           * of the corners in them */
          const int flip = ray.flipXY();
          uint64_t bits;
          memcpy(&bits,leaves + 8*size_t(m),8);
          if (flip & 1) bits = ((bits >> 16) & 0x0000FFFF0000FFFFull) | ((bits & 0x0000FFFF0000FFFFull) << 16);
          if (flip & 2) bits = (bits >> 32) | (bits << 32);
          const vint4 leaf = unpackLanes(bits);
          auto height = [&](int corner) { return vfloat4((leaf >> (4*(corner^flip))) & vint4(15)); };
          const vfloat4 q00 = height(0), q10 = height(1), q01 = height(2), q11 = height(3);
          solid = movemask(vboolf4(leaf == vint4(solidLeaf)));
          empty = movemask(vboolf4(leaf == vint4(emptyLeaf)));

          /* z = lower - e (zScale-1)/2 + bin (height + 1/2); with z -> 1-z its mirror image */
          const float size = zScale*(1.0f/heightBins);
          bin = vfloat4(ray.flip[2] ? -size : size)*c.extent[2];
          base = madd(vfloat4(ray.flip[2] ? 0.5f*(zScale+1.0f) : 0.5f*(1.0f-zScale)),c.extent[2],c.lower[2]);
          q = q00 + vfloat4(0.5f);
          a = q10-q00;
          b = q01-q00;
          twist = (q11-q01)-a;
          rcpX = vfloat4(one)/c.extent[0];
          rcpY = vfloat4(one)/c.extent[1];
        }

        __forceinline vfloat4 z (const vfloat4& u, const vfloat4& v) const { return madd(bin,madd(u,a,madd(v,madd(u,twist,b),q)),base); }
        __forceinline float slopeX (size_t i, float v) const { return (solid >> i) & 1 ? 0.0f : bin[i]*(a[i]+v*twist[i])*rcpX[i]; }
        __forceinline float slopeY (size_t i, float u) const { return (solid >> i) & 1 ? 0.0f : bin[i]*(b[i]+u*twist[i])*rcpY[i]; }

        /*! 4 x 16 bits to 4 lanes */
        static __forceinline vint4 unpackLanes (uint64_t bits) {
          return vint4(_mm_unpacklo_epi16(_mm_cvtsi64_si128((long long)bits),_mm_setzero_si128()));
        }
      };

      /*! a ray and up to four patches: f at entry and exit, and what it says */
      struct PatchCrossing
      {
        vfloat4 s0, s1;      //!< entry and exit, within the segment
        vfloat4 u0, v0, u1, v1;
        vfloat4 f0, f1;
        size_t above0, above1; //!< side at entry and exit, in the frame
        size_t near;           //!< within half a bin at one of them
        size_t started;        //!< the segment starts inside, at tnear
        size_t ended;          //!< it ends inside, at tfar

        __forceinline PatchCrossing (const LocalRay& local, const MirroredRay& ray, const ChildBoxes& c, const HeightPatches& patch)
        {
          s0 = max(c.sNear,vfloat4(zero));
          s1 = min(c.sFar,vfloat4(one));
          auto position = [&](const vfloat4& s, int axis, const vfloat4& rcp) {
            return clamp((madd(s,ray.D[axis],ray.P[axis])-c.lower[axis])*rcp,vfloat4(zero),vfloat4(one));
          };
          u0 = position(s0,0,patch.rcpX); v0 = position(s0,1,patch.rcpY);
          u1 = position(s1,0,patch.rcpX); v1 = position(s1,1,patch.rcpY);
          f0 = madd(s0,ray.D[2],ray.P[2]) - patch.z(u0,v0);
          f1 = madd(s1,ray.D[2],ray.P[2]) - patch.z(u1,v1);

          const vboolf4 inside0 = startsInside(local,c), inside1 = endsInside(local,c);
          started = movemask(inside0);
          ended = movemask(inside1);
          near = movemask(min(abs(f0),abs(f1)) <= madd(vfloat4(0.5f),abs(patch.bin),vfloat4(ray.epsilonZ)));

          /* mirrored, a ray enters through lower and leaves through upper faces */
          const vfloat4 lowerFace = (c.lower[2]-ray.Pnear[2])*ray.rcpD[2], upperFace = (c.lower[2]+c.extent[2]-ray.Pfar[2])*ray.rcpD[2];
          const vboolf4 below0 = (f0 < vfloat4(zero)) | ((lowerFace >= c.sNear) & !inside0);
          const vboolf4 up1 = (f1 >= vfloat4(zero)) | ((upperFace <= c.sFar) & !inside1);
          const size_t flip = ray.flip[2] ? 15 : 0;
          above0 = movemask(!below0) ^ flip;
          above1 = movemask(up1) ^ flip;
        }

        /*! s where f changes sign. u and v are linear along the ray, so
         *  f(k) = f0 + k (f1-f0) + saddle k (1-k) for k from 0 to 1. */
        __forceinline float root (size_t i, const HeightPatches& patch) const
        {
          const float f0 = this->f0[i], f1 = this->f1[i];
          const float saddle = patch.bin[i]*patch.twist[i]*(u1[i]-u0[i])*(v1[i]-v0[i]);
          return s0[i] + rootOfPatch(f0,f1,saddle)*(s1[i]-s0[i]);
        }

        static __forceinline float rootOfPatch (float f0, float f1, float saddle)
        {
          /* the side came from a face of the box: the end nearer to the patch */
          if ((f0 < 0.0f) == (f1 < 0.0f)) return abs(f0) < abs(f1) ? 0.0f : 1.0f;
          /* saddle k^2 - b k - f0 = 0; q does not cancel, and exactly one root is between */
          const float b = f1-f0+saddle;
          const float d = sqrt(max(b*b + 4.0f*saddle*f0,0.0f));
          const float q = 0.5f*(b + (b < 0.0f ? -d : d));
          const float k = -f0/q;
          if (k >= 0.0f && k <= 1.0f) return k;
          return clamp(q/saddle,0.0f,1.0f);
        }
      };

      template<typename RayType>
      struct HeightLeaf : public LeafGroup<RayType>
      {
        enum Side { UNKNOWN, BELOW, ABOVE };

        Side side;            //!< on which the ray left the last leaf
        bool pending;         //!< it was within half a bin of that leaf
        bool fromSurface;     //!< the ray starts in a leaf, within half a bin
        bool found;           //!< a hit was accepted
        float exitS, exitU, exitV, exitSlopeX, exitSlopeY;
        uint32_t exitLeaf;

        __forceinline HeightLeaf (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block,
                                  const LocalRay& local, const MirroredRay& mirrored, const char* data)
          : LeafGroup<RayType>(ray,context,pre,block,local,mirrored,data), side(UNKNOWN), pending(false), fromSurface(false), found(false) {}

        __forceinline bool wantsPassed () const { return pending; }

        __forceinline bool passedAbove (bool above)
        {
          const Side now = above ? ABOVE : BELOW;
          if (side == now) return false;
          side = now;
          pending = false;
          return accept(this->reportHit(exitS,exitLeaf,exitU,exitV,exitSlopeX,exitSlopeY));
        }

        __forceinline bool leaves (const ChildBoxes& c, const HitMasks& masks, const ChildOrder& order, uint32_t m)
        {
          const MirroredRay& ray = this->mirrored;
          const HeightPatches patch(this->data,m,decodeZScale(this->block->zScale()),ray,c);
          const PatchCrossing x(this->local,ray,c,patch);

          auto hitAt = [&](size_t i, float s) {
            const float u = clamp((ray.P[0][0]+s*ray.D[0][0]-c.lower[0][i])*patch.rcpX[i],0.0f,1.0f);
            const float v = clamp((ray.P[1][0]+s*ray.D[1][0]-c.lower[1][i])*patch.rcpY[i],0.0f,1.0f);
            return accept(this->reportHit(s,this->child(m,i),u,v,patch.slopeX(i,v),patch.slopeY(i,u)));
          };

          size_t events = order.toOrder(masks.hit | masks.passed);
          while (events)
          {
            const size_t i = order.lane(bscf(events)), bit = size_t(1) << i;
            if (!(masks.hit & bit)) {
              if (pending && passedAbove(ray.isAbove(c,i))) return true;
              continue;
            }
            const bool started = x.started & bit;
            const Side enter = x.above0 & bit ? ABOVE : BELOW, leave = x.above1 & bit ? ABOVE : BELOW;
            if (found) {
              /* only what lies nearer than the hit can still be of interest */
              if ((patch.empty & bit) || (enter == leave && !(patch.solid & bit)) || ((patch.solid & bit) && started)) continue;
              const float s = patch.solid & bit ? x.s0[i] : x.root(i,patch);
              if (s < this->sBest) hitAt(i,s);
              continue;
            }
            if ((patch.solid | patch.empty) & bit) {
              side = UNKNOWN; pending = false;
              if ((patch.solid & bit) && !started && hitAt(i,x.s0[i])) return true;
              continue;
            }
            if (started) fromSurface = x.near & bit;
            const bool beyond = fromSurface && !started && side == leave;
            const bool step = !started && side != UNKNOWN && side != enter && !beyond;
            const bool border = (x.near & bit) && !((x.started | x.ended) & bit) && onBorder(this->child(m,i));
            if (step) { if (hitAt(i,x.s0[i])) return true; }
            else if (enter != leave && !beyond) { if (hitAt(i,x.root(i,patch))) return true; }
            else if (enter == leave && border) { if (hitAt(i,abs(x.f0[i]) < abs(x.f1[i]) ? x.s0[i] : x.s1[i])) return true; }
            if (found) continue;
            side = leave;
            pending = x.near & bit;
            if (pending) {
              exitS = x.s1[i]; exitU = x.u1[i]; exitV = x.v1[i]; exitLeaf = this->child(m,i);
              exitSlopeX = patch.slopeX(i,exitV);
              exitSlopeY = patch.slopeY(i,exitU);
            }
          }
          return false;
        }

      private:
        /*! true when the walk may end */
        __forceinline bool accept (bool accepted)
        {
          found |= accepted;
          pending &= !accepted;
          return accepted && IsAnyHit<RayType>::value;
        }

        __forceinline bool onBorder (uint32_t leaf) const
        {
          const uint32_t last = (1u << this->block->height()) - 1;
          const uint32_t x = mortonX(leaf), y = mortonY(leaf);
          return x == 0 || y == 0 || x == last || y == last;
        }
      };
    }
  }
}
