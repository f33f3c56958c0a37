// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* visitor1.h, crossing1.h and hit_rule.h with one ray per lane. Hits have the same bits. */

#include "../block_visitorK.h"
#include "crossing.h"

namespace embree::isa::cbvh {
/*! See WalkState. */
template<int K>
struct WalkStates {
  vbool<K> known, above; //!< the side is known; the side is above
  vbool<K> pending, fromSurface, found;

  __forceinline WalkStates() : known(false), above(false), pending(false), fromSurface(false), found(false) {}

  /*! Sets all members but `found` for the rays in `lanes`. */
  __forceinline void assign(const vbool<K>& lanes, const WalkStates& next) {
    known = select(lanes, next.known, known);
    above = select(lanes, next.above, above);
    pending = select(lanes, next.pending, pending);
    fromSurface = select(lanes, next.fromSurface, fromSurface);
  }
};

/*! See Crossing and crossPatch(). */
template<int K>
struct Crossings {
  vfloat<K> s0, s1, u0, v0, u1, v1, f0, f1, saddle;
  vbool<K> enterAbove, leaveAbove, changes, nearEntry, near, started, ended;

  __forceinline Crossings(const NodeRays<K>& rays, const LeafSurfaces& surfaces, uint32_t leaf,
                          const BoxRangesK<K>& box, const vbool<K>& started, const vbool<K>& ended)
    : started(started),
      ended(ended) {
    s0 = max(box.sNear, vfloat<K>(zero));
    s1 = min(box.sFar, vfloat<K>(1.0f));
    const float* footprint = surfaces.footprint[leaf];
    u0 = position(rays, 0, footprint, s0);
    v0 = position(rays, 1, footprint, s0);
    u1 = position(rays, 0, footprint, s1);
    v1 = position(rays, 1, footprint, s1);
    f0 = heightAbove(rays, surfaces.height[leaf], s0, u0, v0);
    f1 = heightAbove(rays, surfaces.height[leaf], s1, u1, v1);
    saddle = vfloat<K>(surfaces.height[leaf][3]) * (u1 - u0) * (v1 - v0);
    enterAbove = f0 >= vfloat<K>(zero);
    leaveAbove = f1 >= vfloat<K>(zero);
    changes = enterAbove ^ leaveAbove;
    enterAbove = select(andn(box.enterZ >= box.sNear, started), rays.descends[2], enterAbove);
    leaveAbove = select(andn(box.leaveZ <= box.sFar, ended), !rays.descends[2], leaveAbove);
    const vfloat<K> tolerance = vfloat<K>(surfaces.halfThickness[leaf]) + rays.epsilonZ;
    nearEntry = abs(f0) <= tolerance;
    near = changes | (min(abs(f0), abs(f1)) <= madd(vfloat<K>(0.25f), abs(saddle), tolerance));
  }

  /*! Position in a leaf's box at s: u for axis 0, v for axis 1. */
  static __forceinline vfloat<K> position(const NodeRays<K>& rays, int axis, const float footprint[4],
                                          const vfloat<K>& s) {
    const vfloat<K> at =
        (madd(s, rays.D[axis], rays.P[axis]) - vfloat<K>(footprint[axis])) * vfloat<K>(footprint[2 + axis]);
    return max(min(at, vfloat<K>(1.0f)), vfloat<K>(zero));
  }

  /*! Ray k, without its event. */
  __forceinline Crossing<float> at(size_t k) const {
    Crossing<float> x;
    x.s0 = s0[k];
    x.s1 = s1[k];
    x.u0 = u0[k];
    x.v0 = v0[k];
    x.u1 = u1[k];
    x.v1 = v1[k];
    x.f.f0 = f0[k];
    x.f.f1 = f1[k];
    x.f.saddle = saddle[k];
    return x;
  }

private:
  static __forceinline vfloat<K> heightAbove(const NodeRays<K>& rays, const float h[4], const vfloat<K>& s,
                                             const vfloat<K>& u, const vfloat<K>& v) {
    const vfloat<K> patch =
        madd(u, vfloat<K>(h[1]), madd(v, madd(u, vfloat<K>(h[3]), vfloat<K>(h[2])), vfloat<K>(h[0])));
    return madd(s, rays.D[2], rays.P[2]) - patch;
  }
};

template<int K, typename Rays>
class LeafVisitorK : public BlockVisitorK<K, Rays> {
  WalkStates<K> state;

  /* Where rays left their last leaf. */
  vint<K> exitLeaf;
  vfloat<K> exitS;

public:
  typedef NodeEntries::LeafTile LeafTile;
  static const uint32_t kind = kindLeaf;
  static const bool tracksPassedBoxes = true;

  template<typename... Args>
  // hits in other blocks do not shorten the walk, see LeafVisitor1
  __forceinline LeafVisitorK(Args&&... args) : BlockVisitorK<K, Rays>(args...) {
    this->sBest = vfloat<K>(1.0f);
  }

  __forceinline LeafTile& leafTile(uint32_t m) { return this->tiles.leafTile(m); }

  __forceinline vbool<K> needsPassedBoxes() const { return state.pending | !(state.known | state.found); }

  /*! As passBox(). */
  __forceinline void passBoxes(const vbool<K>& above, const vbool<K>& lanes) {
    const vbool<K> step = lanes & state.pending & (state.above ^ above);
    const vbool<K> before = state.above;
    state.above = select(lanes, above, state.above);
    state.known |= lanes;
    state.pending = andn(state.pending, step);
    if (unlikely(any(step))) reportExits(step, before);
  }

  void leaf(const LeafTile& tile, uint32_t m, uint32_t grandchild, const BoxRangesK<K>& box, const vbool<K>& lanes) {
    const LeafSurfaces& surfaces = tile.surfaces;
    const Crossings<K> x(this->nodeRays, surfaces, grandchild, box, this->startsInside(box), this->endsInside(box));
    WalkStates<K> next = state;
    const vbool<K> unhit = andn(lanes, state.found);
    vbool<K> hit; // rays that hit: at the entry, unless `root` or `lip` is set
    vbool<K> root(false), lip(false);
    LeafHits<K> hits;
    hits.fromAbove = hits.fromBelow = vbool<K>(false);

    /* As crossLeaf(). */
    if (unlikely(((surfaces.solid | surfaces.empty) >> grandchild) & 1u)) {
      hit = (surfaces.solid >> grandchild) & 1u ? andn(lanes, x.started) : vbool<K>(false);
      next.known = next.pending = vbool<K>(false);
    } else {
      const vbool<K> crosses = (x.enterAbove ^ x.leaveAbove) | x.changes;
      next.fromSurface = select(x.started, x.nearEntry, state.fromSurface);
      next.known = vbool<K>(true);
      next.above = x.leaveAbove;
      next.pending = x.near;
      const vbool<K> isPastStep = andn(andn(next.fromSurface & state.known, x.started), state.above ^ x.leaveAbove);
      const vbool<K> differs = andn(state.known & (state.above ^ x.enterAbove), x.started);
      const vbool<K> step = andn(unhit & differs, isPastStep);
      hits.fromAbove = step & state.above;
      hits.fromBelow = andn(step, state.above);
      root = andn(lanes & crosses, step | (unhit & isPastStep));
      if (isAtBorder(16 * m + grandchild))
        lip = andn(andn(andn(andn(unhit & x.near, crosses), step), x.started), x.ended);
      hit = step | root | lip;
    }
    if (any(hit)) {
      hits.s = x.s0;
      for (uint32_t rest = uint32_t(movemask(root)); rest; rest &= rest - 1) {
        const uint32_t k = uint32_t(bsf(rest));
        const Crossing<float> at = x.at(k);
        hits.s[k] = between(at, parabolaRoot(at.f));
      }
      if (unlikely(any(lip)))
        hit = andn(hit, raysMissingLips(lip, x, surfaces.halfThickness[grandchild], 16 * m + grandchild, hits.s));
      hit = andn(hit, andn(state.found, hits.s < this->sBest));
    }
    state.assign(unhit, next);
    exitLeaf = select(unhit, vint<K>(int(16 * m + grandchild)), exitLeaf);
    exitS = select(unhit, x.s1, exitS);
    if (any(hit)) {
      setSurface(hits, surfaces, grandchild);
      markFound(this->reportHits(hit, 16 * m + grandchild, hits));
    }
  }

private:
  /*! As afterHit(). */
  __forceinline void markFound(const vbool<K>& accepted) {
    state.found |= accepted;
    state.pending = andn(state.pending, accepted);
  }

  /*! As leafHit in visitor1.h. */
  __forceinline void setSurface(LeafHits<K>& hits, const LeafSurfaces& surfaces, uint32_t grandchild) const {
    const float* h = surfaces.height[grandchild];
    const float* footprint = surfaces.footprint[grandchild];
    hits.u = Crossings<K>::position(this->nodeRays, 0, footprint, hits.s);
    hits.v = Crossings<K>::position(this->nodeRays, 1, footprint, hits.s);
    hits.slopeX = hits.slopeY = vfloat<K>(zero);
    if (unlikely((surfaces.solid >> grandchild) & 1u)) return;
    hits.slopeX = madd(hits.v, vfloat<K>(h[3]), vfloat<K>(h[1])) * vfloat<K>(footprint[2]);
    hits.slopeY = madd(hits.u, vfloat<K>(h[3]), vfloat<K>(h[2])) * vfloat<K>(footprint[3]);
  }

  /*! Reports hits where the rays in `lanes` left their last leaf. above: remembered side. */
  __noinline void reportExits(const vbool<K>& lanes, const vbool<K>& above) {
    for (uint32_t rest = uint32_t(movemask(lanes)); rest; rest &= rest - 1) {
      const uint32_t k = uint32_t(bsf(rest)), leaf = uint32_t(exitLeaf[k]);
      LeafTile& tile = leafTile(leaf >> 4);
      this->tiles.ensureDecoded(tile, 1u << ((leaf >> 2) & 3u));
      LeafHits<K> hits;
      hits.s = exitS;
      hits.fromAbove = above;
      hits.fromBelow = !above;
      setSurface(hits, tile.surfaces, leaf & 15u);
      markFound(this->reportHits(vbool<K>(int(1u << k)), leaf, hits));
    }
  }

  __forceinline bool isAtBorder(uint32_t leaf) const {
    const uint32_t x = mortonX(leaf), y = mortonY(leaf), last = this->layout.leavesPerSide - 1;
    return x == 0 || y == 0 || x == last || y == last;
  }

  /*! Returns the rays of `lanes` that hit no lip. Sets s of all rays in `lanes`. */
  __noinline vbool<K> raysMissingLips(const vbool<K>& lanes, const Crossings<K>& x, float halfThickness, uint32_t leaf,
                                      vfloat<K>& s) const {
    uint32_t missed = 0;
    for (uint32_t rest = uint32_t(movemask(lanes)); rest; rest &= rest - 1) {
      const uint32_t k = uint32_t(bsf(rest));
      const Crossing<float> at = x.at(k);
      const Lip<float> lip = {borderWidthOf(this->block->info), halfThickness, this->nodeRays.epsilonZ[k]};
      const LipIntersection<float> intersection =
          intersectLipsOfLeaf(at, mortonX(leaf), mortonY(leaf), this->layout.leavesPerSide - 1, lip);
      s[k] = between(at, intersection.k);
      if (!intersection.hit) missed |= 1u << k;
    }
    return vbool<K>(int(missed));
  }

  static __forceinline float between(const Crossing<float>& x, float k) { return fused(k, x.s1 - x.s0, x.s0); }
};
} // namespace embree::isa::cbvh
