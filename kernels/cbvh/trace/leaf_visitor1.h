// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Leaves of cLEAF. patch_crossing4.h measures how the ray crosses them, codec/hit_rule.h
 * decides where it hits, and this reports it. */

#include "patch_crossing4.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      template<typename RayType>
      struct LeafVisitor1 : public BlockVisitor1<RayType>
      {
        using BlockVisitor1<RayType>::BlockVisitor1;

        WalkState state = startOfWalk();
        LeafHit exit;         //!< where the ray left the last leaf, if the state is pending
        GroupPatches patch;

        __forceinline void decode (uint32_t word, uint32_t m, const ParentBox& parent, ChildBoxes& c)
        {
          uint64_t bits;
          memcpy(&bits,this->data + 8*size_t(m),8);
          patch.decode(word,bits,parent,this->mirrored,c);
        }

        __forceinline bool wantsPassed () const { return cbvh::wantsPassed(state); }

        __forceinline bool passedAbove (bool above)
        {
          const Verdict v = passBox(state,above);
          state = v.next;
          if (v.hit == hitNone) return false;
          exit.from = v.from;
          return accept(this->reportHit(exit));
        }

        __forceinline bool leaves (const ChildBoxes& c, const HitMasks& masks, const ChildOrder& order, uint32_t m)
        {
          const MirroredRay& ray = this->mirrored;
          const PatchCrossing4 x(this->local,ray,c,patch);
          size_t events = order.toOrder(masks.hit | masks.passed);
          while (events)
          {
            const size_t i = order.lane(bscf(events));
            if (!((masks.hit >> i) & 1)) {
              if (wantsPassed() && passedAbove(ray.isAbove(c,i))) return true;
              continue;
            }
            const Verdict v = crossLeaf(state,x.event(i));
            float s;
            if (isMet(v.hit,x,i,m,s) && !(state.found && !(s < this->sBest))) {
              if (accept(this->reportHit(hitAt(c,m,i,s,v.from)))) return true;
              if (state.found) continue;
            }
            state = v.next;
            if (state.pending) exit = exitOf(x,m,i);
          }
          return false;
        }

      private:
        /*! after a hit was reported; true when the walk may end */
        __forceinline bool accept (bool accepted)
        {
          if (accepted) state = afterHit(state);
          return accepted && IsAnyHit<RayType>::value;
        }

        /*! whether the ray meets what the verdict says, and where */
        __forceinline bool isMet (uint32_t hit, const PatchCrossing4& x, size_t i, uint32_t m, float& s) const
        {
          if (hit == hitNone) return false;
          if (hit == hitLip) return meetsLips(x,i,m,s);
          s = hit == hitRoot ? x.root(i) : x.s0[i];
          return true;
        }

        __forceinline bool meetsLips (const PatchCrossing4& x, size_t i, uint32_t m, float& s) const
        {
          const uint32_t leaf = this->child(m,i), last = this->numLeaves-1;
          const uint32_t cell[2] = { mortonX(leaf), mortonY(leaf) };
          const float p0[2] = { x.u0[i], x.v0[i] }, p1[2] = { x.u1[i], x.v1[i] };
          const Lip<float> lip = { borderWidthOf(this->block->info),patch.reach[i],this->mirrored.epsilonZ };
          const float sign = this->mirrored.flip[2] ? -1.0f : 1.0f;
          const Parabola<float> f = { sign*x.f0[i], sign*x.f1[i], sign*x.saddle[i] }; // lips are below in the frame
          for (int axis=0; axis<2; axis++)
            for (int upper=0; upper<2; upper++)
            {
              if (cell[axis] != (upper ? last : 0)) continue;
              const bool far = upper != this->mirrored.flip[axis];
              const LipMeeting<float> at = meetLip(f,far ? 1.0f-p0[axis] : p0[axis],far ? 1.0f-p1[axis] : p1[axis],lip);
              if (!at.met) continue;
              s = x.s0[i] + at.k*(x.s1[i]-x.s0[i]);
              return true;
            }
          return false;
        }

        __forceinline LeafHit hitAt (const ChildBoxes& c, uint32_t m, size_t i, float s, uint32_t from) const
        {
          const MirroredRay& ray = this->mirrored;
          const float u = clamp((ray.P[0][0]+s*ray.D[0][0]-c.lower[0][i])*patch.rcpX[i],0.0f,1.0f);
          const float v = clamp((ray.P[1][0]+s*ray.D[1][0]-c.lower[1][i])*patch.rcpY[i],0.0f,1.0f);
          return LeafHit{ s,this->child(m,i),u,v,patch.slopeX(i,v),patch.slopeY(i,u),from };
        }

        __forceinline LeafHit exitOf (const PatchCrossing4& x, uint32_t m, size_t i) const
        {
          const float u = x.u1[i], v = x.v1[i];
          return LeafHit{ x.s1[i],this->child(m,i),u,v,patch.slopeX(i,v),patch.slopeY(i,u),sideUnknown };
        }
      };
    }
  }
}
