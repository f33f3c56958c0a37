// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Leaves of cLEAF. leaf_crossing1.h measures how the ray crosses them, codec/hit_rule.h
 * decides where it hits, and this reports it. */

#include "leaf_crossing1.h"

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

        __forceinline NodeEntries::LeafTile& leafTile (uint32_t m) { return this->tiles.leafTile(m); }

        __forceinline bool wantsPassed () const { return cbvh::wantsPassed(state); }

        __forceinline bool passedAbove (bool above)
        {
          const Verdict v = passBox(state,above);
          state = v.next;
          if (v.hit == hitNone) return false;
          exit.from = v.from;
          return accept(this->reportHit(exit));
        }

        __forceinline bool leaf (uint32_t m, uint32_t child, const BoxRanges<16>& ranges)
        {
          const NodeEntries::LeafTile& tile = decoded(m,child);
          const Crossing<float> x = crossDecodedLeaf(this->frameRay,tile,child,ranges,this->startsInside(ranges,child),this->endsInside(ranges,child));
          const Verdict v = crossLeaf(state,x.event);
          float s;
          if (isMet(v.hit,x,tile.surfaces.reach[child],16*m+child,s) && !(state.found && !(s < this->sBest))) {
            if (accept(this->reportHit(leafHit(m,child,s,v.from)))) return true;
            if (state.found) return false;
          }
          state = v.next;
          if (state.pending) exit = leafHit(m,child,x.s1,sideUnknown);
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
        __forceinline bool isMet (uint32_t hit, const Crossing<float>& x, float reach, uint32_t number, float& s) const
        {
          if (hit == hitNone) return false;
          if (unlikely(hit == hitLip)) return meetsLips(x,reach,number,s);
          s = hit == hitRoot ? between(x,parabolaRoot(x.f)) : x.s0;
          return true;
        }

        __noinline bool meetsLips (const Crossing<float>& x, float reach, uint32_t number, float& s) const
        {
          const Lip<float> lip = { borderWidthOf(this->block->info),reach,this->frameRay.epsilonZ };
          const LipMeeting<float> at = meetLipsOfLeaf(x,mortonX(number),mortonY(number),this->layout.leaves-1,lip);
          s = between(x,at.k);
          return at.met;
        }

        /*! s of a place from entry to exit */
        static __forceinline float between (const Crossing<float>& x, float k) { return x.s0 + k*(x.s1-x.s0); }

        /*! a leaf's tile, whatever has been traced since the leaf was met */
        __forceinline const NodeEntries::LeafTile& decoded (uint32_t m, uint32_t child)
        {
          NodeEntries::LeafTile& tile = leafTile(m);
          this->tiles.need(tile,1u << (child >> 2));
          return tile;
        }

        /*! a hit at s in a leaf */
        __forceinline LeafHit leafHit (uint32_t m, uint32_t child, float s, uint32_t from)
        {
          const LeafSurfaces& surfaces = decoded(m,child).surfaces;
          const vfloat4 place = positionInLeaf(this->frameRay,surfaces,child,vfloat4(s));
          const float* h = surfaces.height[child];
          const float u = place[0], v = place[1];
          const bool flat = (surfaces.solid >> child) & 1u;
          return LeafHit{ s,16*m+child,u,v,flat ? 0.0f : (h[1]+v*h[3])*surfaces.place[child][2],flat ? 0.0f : (h[2]+u*h[3])*surfaces.place[child][3],from };
        }
      };
    }
  }
}
