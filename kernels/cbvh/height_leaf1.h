// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Leaves of cLEAF: bilinear patches, leaf_codec.h.
 *
 * Along a ray
 *
 *   f(s) = z of the ray - z of the leaf's patch,
 *
 * taken where the ray enters and leaves the leaf's box (the paper's line test; its
 * root is that of the patch, not of the line). Through the lower (upper) face of the
 * box a ray passes below (above) the surface, whatever the patch says. The ray hits
 * where f changes sign.
 *
 * Patches of neighbouring groups do not meet exactly, each is off the edge between them
 * by up to half a thickness, and a ray could slip through the step. Therefore the ray
 * remembers on which side it left the last leaf. It hits
 *
 * - at the entry of a leaf, if it enters on the other side;
 * - where it left a leaf within half a thickness, if it then passes over (under) the boxes
 *   that come next, but was under (over) that leaf;
 * - a lip at the border of the block, as the neighbour is in another block, which knows
 *   nothing of the ray's side.
 *
 *      surface of A  ____           The encoder keeps both surfaces above the edge that
 *      ---------.....|   ....---    they share, and less than half a thickness. Lips
 *                 lip|---|lip       hang from the border that far down: each reaches the
 *                     edge          edge, so together they close what is between.
 *
 * Inside a block that is watertight because leaves, and boxes passed, cover the ray's
 * way in x and y without a gap, so no change of side goes unseen. Lips are below the
 * surface so that rays that pass over it, along a silhouette or away from it, do not
 * meet them.
 *
 * A ray that starts on the surface of a leaf, within half a thickness, does not hit a
 * step that it is beyond again when it leaves the step's leaf: it would shadow the
 * surface it comes from. A segment that starts (ends) in a leaf, at tnear (tfar), hits it
 * only if f changes sign.
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
#include "height_patches1.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! a ray and up to four patches: f at entry and exit, and what it says */
      struct PatchCrossing
      {
        vfloat4 s0, s1;      //!< entry and exit, within the segment
        vfloat4 u0, v0, u1, v1;
        vfloat4 f0, f1;
        size_t above0, above1; //!< side at entry and exit, in the frame
        vfloat4 saddle;        //!< f(k) = f0 + k (f1-f0) + saddle k (1-k), k from 0 to 1
        size_t near0;          //!< within reach of the patch at entry
        size_t near;           //!< may be anywhere up to the exit
        size_t changes;        //!< f has another sign at the exit
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
          saddle = patch.bin*patch.twist*(u1-u0)*(v1-v0);
          const vfloat4 reach = patch.reach + vfloat4(ray.epsilonZ);
          near0 = movemask(abs(f0) <= reach);
          const vboolf4 change = (f0 < vfloat4(zero)) != (f1 < vfloat4(zero));
          changes = movemask(change);
          near = movemask((min(abs(f0),abs(f1)) <= madd(vfloat4(0.25f),abs(saddle),reach)) | change);

          /* mirrored, a ray enters through lower and leaves through upper faces */
          const vfloat4 lowerFace = (c.lower[2]-ray.Pnear[2])*ray.rcpD[2], upperFace = (c.lower[2]+c.extent[2]-ray.Pfar[2])*ray.rcpD[2];
          const vboolf4 below0 = (f0 < vfloat4(zero)) | ((lowerFace >= c.sNear) & !inside0);
          const vboolf4 up1 = (f1 >= vfloat4(zero)) | ((upperFace <= c.sFar) & !inside1);
          const size_t flip = ray.flip[2] ? 15 : 0;
          above0 = movemask(!below0) ^ flip;
          above1 = movemask(up1) ^ flip;
        }

        /*! s where f changes sign */
        __forceinline float root (size_t i) const {
          return s0[i] + rootOfPatch(f0[i],f1[i],saddle[i])*(s1[i]-s0[i]);
        }

        /*! Whether the ray meets the lip that closes the block's border: what is up to reach
         *  below the patch, at positions u (v) up to width from that side; s is a place. sign: -1
         *  where z is mirrored. Over that part f is a parabola, largest and smallest at its
         *  ends or its vertex. */
        __forceinline bool meetsLip (size_t i, bool upper, float p0, float p1, float width, float reach, float epsilon, float sign, float& s) const
        {
          const float f0 = this->f0[i], f1 = this->f1[i], saddle = this->saddle[i], d = p1-p0;
          float k0 = 0.0f, k1 = 1.0f;
          if (upper) {
            if (p1 < 1.0f-width) return false;
            if (p0 < 1.0f-width) k0 = (1.0f-width-p0)/d;
          } else {
            if (p0 > width) return false;
            if (p1 > width) k1 = (width-p0)/d;
          }
          float lowest = pos_inf, highest = neg_inf, k = k0;
          bool inside = false;
          auto sample = [&](float kj) {
            const float f = sign*(f0 + kj*(f1-f0) + saddle*kj*(1.0f-kj));
            lowest = min(lowest,f);
            highest = max(highest,f);
            if (!inside && f <= epsilon && f >= -(reach+epsilon)) { inside = true; k = kj; }
          };
          sample(k0);
          sample(k1);
          const float vertex = 0.5f + 0.5f*(f1-f0)/saddle;
          if (vertex > k0 && vertex < k1) sample(vertex);
          s = s0[i] + k*(s1[i]-s0[i]);
          return lowest <= epsilon && highest >= -(reach+epsilon);
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
        bool pending;         //!< it was within half a thickness of that leaf
        bool fromSurface;     //!< the ray starts in a leaf, within half a thickness
        bool found;           //!< a hit was accepted
        float exitS, exitU, exitV, exitSlopeX, exitSlopeY;
        uint32_t exitLeaf;
        uint32_t cells;       //!< leaves along a side of the block
        HeightPatches patch;

        __forceinline void decode (uint32_t word, uint32_t m, const vfloat4 lower[3], const vfloat4 extent[3], ChildBoxes& c) {
          patch.decode(word,this->data,m,this->mirrored,lower,extent,c);
        }

        __forceinline HeightLeaf (RayType& ray, IntersectContext* context, const RayPrecalculations& pre, const Block* block,
                                  const LocalRay& local, const MirroredRay& mirrored, const char* data)
          : LeafGroup<RayType>(ray,context,pre,block,local,mirrored,data), side(UNKNOWN), pending(false), fromSurface(false), found(false)
        {
          cells = 1u << block->height();
          if (cells == 1) { cells = 2; this->leafSize = 0.5f; }
        }

        __forceinline bool wantsPassed () const { return pending || (side == UNKNOWN && !found); }

        __forceinline bool passedAbove (bool above)
        {
          const Side before = side, now = above ? ABOVE : BELOW;
          if (before == now) return false;
          side = now;
          if (before == UNKNOWN) return false;
          pending = false;
          return accept(this->reportHit(exitS,exitLeaf,exitU,exitV,exitSlopeX,exitSlopeY,above ? -1.0f : 1.0f));
        }

        __forceinline bool leaves (const ChildBoxes& c, const HitMasks& masks, const ChildOrder& order, uint32_t m)
        {
          const MirroredRay& ray = this->mirrored;
          const PatchCrossing x(this->local,ray,c,patch);

          auto hitAt = [&](size_t i, float s, Side from) {
            const float u = clamp((ray.P[0][0]+s*ray.D[0][0]-c.lower[0][i])*patch.rcpX[i],0.0f,1.0f);
            const float v = clamp((ray.P[1][0]+s*ray.D[1][0]-c.lower[1][i])*patch.rcpY[i],0.0f,1.0f);
            return accept(this->reportHit(s,this->child(m,i),u,v,patch.slopeX(i,v),patch.slopeY(i,u),
                                          from == UNKNOWN ? 0.0f : from == ABOVE ? 1.0f : -1.0f));
          };

          size_t events = order.toOrder(masks.hit | masks.passed);
          while (events)
          {
            const size_t i = order.lane(bscf(events)), bit = size_t(1) << i;
            if (!(masks.hit & bit)) {
              if (wantsPassed() && passedAbove(ray.isAbove(c,i))) return true;
              continue;
            }
            const bool started = x.started & bit;
            const Side enter = x.above0 & bit ? ABOVE : BELOW, leave = x.above1 & bit ? ABOVE : BELOW;
            const bool crosses = enter != leave || (x.changes & bit);
            if (found) {
              /* only what lies nearer than the hit can still be of interest */
              if ((patch.empty & bit) || (!crosses && !(patch.solid & bit)) || ((patch.solid & bit) && started)) continue;
              const float s = patch.solid & bit ? x.s0[i] : x.root(i);
              if (s < this->sBest) hitAt(i,s,UNKNOWN);
              continue;
            }
            if ((patch.solid | patch.empty) & bit) {
              side = UNKNOWN; pending = false;
              if ((patch.solid & bit) && !started && hitAt(i,x.s0[i],UNKNOWN)) return true;
              continue;
            }
            if (started) fromSurface = x.near0 & bit;
            const bool beyond = fromSurface && !started && side == leave;
            const bool step = !started && side != UNKNOWN && side != enter && !beyond;
            const bool mayMeetLip = x.near & ~(x.started | x.ended) & bit;
            float sLip;
            if (step) { if (hitAt(i,x.s0[i],side)) return true; }
            else if (crosses && !beyond) { if (hitAt(i,x.root(i),UNKNOWN)) return true; }
            else if (!crosses && mayMeetLip && meetsLip(x,i,m,sLip)) { if (hitAt(i,sLip,UNKNOWN)) return true; }
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

        /*! whether the ray meets a lip of leaf i of group m, and where */
        __forceinline bool meetsLip (const PatchCrossing& x, size_t i, uint32_t m, float& s) const
        {
          const uint32_t leaf = this->child(m,i), last = cells-1;
          const uint32_t cell[2] = { mortonX(leaf), mortonY(leaf) };
          const float p0[2] = { x.u0[i], x.v0[i] }, p1[2] = { x.u1[i], x.v1[i] };
          const float width = this->block->borderWidth(), reach = patch.reach[i], epsilon = this->mirrored.epsilonZ;
          const float sign = this->mirrored.flip[2] ? -1.0f : 1.0f;
          for (int axis=0; axis<2; axis++)
          {
            const bool flip = this->mirrored.flip[axis];
            if (cell[axis] == 0    && x.meetsLip(i,flip, p0[axis],p1[axis],width,reach,epsilon,sign,s)) return true;
            if (cell[axis] == last && x.meetsLip(i,!flip,p0[axis],p1[axis],width,reach,epsilon,sign,s)) return true;
          }
          return false;
        }
      };
    }
  }
}
