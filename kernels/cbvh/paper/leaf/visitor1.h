// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Visitor of block_walk1.h for leaves of cLEAF. hit_rule.h decides where the ray hits. */

#include "crossing1.h"

namespace embree::isa::cbvh {
template<typename RayType>
struct LeafVisitor1 : public BlockVisitor1<RayType> {
  typedef NodeEntries::LeafTile LeafTile;
  static const uint32_t kind = kindLeaf;

  /*! Hits in other blocks do not shorten the walk: a hit before them can depend on boxes after them. */
  template<typename... Args>
  __forceinline LeafVisitor1(Args&&... args) : BlockVisitor1<RayType>(args...) {
    this->sBest = 1.0f;
  }

  WalkState state = startOfWalk();
  uint32_t passedMask = ~0u;

  __forceinline LeafTile& leafTile(uint32_t m) { return this->tiles.leafTile(m); }

  bool passSubtree(bool above) {
    const HitResult result = passBox(state, above);
    setState(result.next);
    return result.hit != hitNone && reportExit(result.from);
  }

  __forceinline bool leaf(const LeafTile& tile, uint32_t m, uint32_t grandchild, const BoxRanges<16>& ranges) {
    const Crossing<float> x =
        crossDecodedLeaf(this->nodeRay, tile, grandchild, ranges, this->startsInside(ranges, grandchild),
                         this->endsInside(ranges, grandchild));
    const HitResult result = crossLeaf(state, x.event);
    float s;
    if (hitsLeaf(result.hit, x, tile.surfaces.halfThickness[grandchild], 16 * m + grandchild, s) &&
        !(state.found && !(s < this->sBest))) {
      if (endsWalk(this->reportHit(16 * m + grandchild, leafHit(tile.surfaces, grandchild, s, result.from))))
        return true;
      if (state.found) return false;
    }
    setState(result.next);
    exitM = m;
    exitChild = grandchild;
    exitS = x.s1;
    return false;
  }

private:
  /* Where the ray left the last leaf: the leaf is 16 exitM + exitChild. */
  uint32_t exitM, exitChild;
  float exitS;

  /*! Reports a hit where the ray left the last leaf. Returns true if the walk may end. from: see HitResult. */
  __noinline bool reportExit(uint32_t from) {
    LeafTile& tile = leafTile(exitM);
    this->tiles.ensureDecoded(tile, 1u << (exitChild >> 2));
    return endsWalk(this->reportHit(16 * exitM + exitChild, leafHit(tile.surfaces, exitChild, exitS, from)));
  }

  __forceinline void setState(const WalkState& next) {
    state = next;
    passedMask = needsPassedBoxes(state) ? ~0u : 0u;
  }

  /*! Updates the state after a report. Returns true if the walk may end. */
  __forceinline bool endsWalk(bool accepted) {
    if (accepted) setState(afterHit(state));
    return accepted && IsAnyHit<RayType>::value;
  }

  /*! Returns true if the ray hits the leaf, and sets s. hit: HitResult::hit. number: Morton index of the leaf. */
  __forceinline bool hitsLeaf(uint32_t hit, const Crossing<float>& x, float halfThickness, uint32_t number,
                              float& s) const {
    if (hit == hitNone) return false;
    if (unlikely(hit == hitLip)) return intersectsLips(x, halfThickness, number, s);
    s = hit == hitRoot ? between(x, parabolaRoot(x.f)) : x.s0;
    return true;
  }

  __noinline bool intersectsLips(const Crossing<float>& x, float halfThickness, uint32_t number, float& s) const {
    const Lip<float> lip = {borderWidthOf(this->block->info), halfThickness, this->nodeRay.epsilonZ};
    const LipIntersection<float> at =
        intersectLipsOfLeaf(x, mortonX(number), mortonY(number), this->layout.leavesPerSide - 1, lip);
    s = between(x, at.k);
    return at.hit;
  }

  /*! s at position k of a crossing. */
  static __forceinline float between(const Crossing<float>& x, float k) { return fused(k, x.s1 - x.s0, x.s0); }

  /*! from: see HitResult. */
  __forceinline LeafHit1 leafHit(const LeafSurfaces& surfaces, uint32_t grandchild, float s, uint32_t from) const {
    const vfloat4 uv = positionInLeaf(this->nodeRay, surfaces, grandchild, vfloat4(s));
    const float* h = surfaces.height[grandchild];
    const float u = uv[0], v = uv[1];
    const bool flat = (surfaces.solid >> grandchild) & 1u;
    const float slopeX = fused(v, h[3], h[1]) * surfaces.footprint[grandchild][2],
                slopeY = fused(u, h[3], h[2]) * surfaces.footprint[grandchild][3];
    return LeafHit1{s, u, v, flat ? 0.0f : slopeX, flat ? 0.0f : slopeY, from == sideAbove, from == sideBelow};
  }
};
} // namespace embree::isa::cbvh
