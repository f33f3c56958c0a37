// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* RayState, LocalRay (local_ray4.h), NodeRay and BoxRanges (node_ray.h) for packets, with one ray per lane and the same
 * bits as for single rays. Lanes of inactive rays are undefined. */

#include "node_ray.h"

namespace embree::isa::cbvh {
/*! See RayState. */
template<int K>
struct RayStates {
  Vec3vf<K> org, dir;
  vfloat<K> scale, rcpScale, rcpDir2, scaledTnear, tfar, entryT;
  mutable NearestHit nearest[K];
  bool isSet;

  __forceinline explicit RayStates(const vfloat<K>& tfar) : tfar(tfar), entryT(neg_inf), isSet(false) {}

  __forceinline void set(const RayK<K>& rays) {
    if (likely(isSet)) return;
    isSet = true;
    const Vec3vf<K> d = rays.dir;
    rcpScale = max(max(abs(d.x), abs(d.y)), abs(d.z));
    scale = vfloat<K>(1.0f) / nonZero(rcpScale);
    dir = Vec3vf<K>(d.x * scale, d.y * scale, d.z * scale);
    org = rays.org;
    rcpDir2 = vfloat<K>(1.0f) / dotOf(dir, dir); // at least 1, or NaN
    scaledTnear = product(max(vfloat<K>(rays.tnear()), vfloat<K>(zero)), rcpScale);
  }

  /*! See NearestHit::finalTfar. */
  __forceinline void setFinalTfar(const vbool<K>& valid, vfloat<K>& currentTfar) const {
    for (uint32_t rest = uint32_t(movemask(valid)); rest; rest &= rest - 1) {
      const uint32_t k = uint32_t(bsf(rest));
      currentTfar[k] = nearest[k].finalTfar(currentTfar[k]);
    }
  }

  /*! Rounds like dot() of Vec3fa. */
  static __forceinline vfloat<K> dotOf(const Vec3vf<K>& a, const Vec3vf<K>& b) {
    return (product(a.x, b.x) + product(a.y, b.y)) + product(a.z, b.z);
  }
};

template<int K>
struct NodeRays {
  /* see NodeRay */
  vfloat<K> P[3], D[3];
  vfloat<K> Pnear[3], Pfar[3], rcpD[3];
  vfloat<K> epsilonZ;
  vbool<K> descends[3]; //!< by axis

  /* see LocalRay */
  vfloat<K> t0, t1, w0, w1;
  vbool<K> startClipped, endClipped;

  /*! See LocalRay::init. Returns the rays that intersect the block's box. */
  __forceinline vbool<K> init(const RayStates<K>& state, const Block* block, const vfloat<K>& nearestT,
                              const vbool<K>& valid) {
    const vfloat<K> o[3] = {state.org.x - vfloat<K>(block->center[0]), state.org.y - vfloat<K>(block->center[1]),
                            state.org.z - vfloat<K>(block->center[2])};
    const vfloat<K> tref = -state.dotOf(Vec3vf<K>(o[0], o[1], o[2]), state.dir) * state.rcpDir2;
    const vfloat<K> p[3] = {madd(tref, state.dir.x, o[0]), madd(tref, state.dir.y, o[1]),
                            madd(tref, state.dir.z, o[2])};
    vfloat<K> O[4], dO[4];
    for (int r = 0; r < 4; r++) {
      const vfloat<K> cx(block->columns[0][r]), cy(block->columns[1][r]), cz(block->columns[2][r]);
      O[r] = madd(p[0], cx, madd(p[1], cy, madd(p[2], cz, vfloat<K>(r < 3 ? 0.5f : 1.0f))));
      dO[r] = madd(state.dir.x, cx, madd(state.dir.y, cy, product(state.dir.z, cz)));
    }

    const BlockStretch stretch(vfloat4::load(block->columns[0]), vfloat4::load(block->columns[1]),
                               vfloat4::load(block->columns[2]));
    const vfloat<K> farthest =
        madd(vfloat<K>(relativeBoxRadius), vfloat<K>(stretch.longest), max(max(abs(o[0]), abs(o[1])), abs(o[2])));
    const vfloat<K> displacement = vfloat<K>(distanceUlps * floatUlp) * farthest;
    vfloat<K> epsilon[3];
    for (int k = 0; k < 3; k++)
      epsilon[k] = madd(displacement, vfloat<K>(stretch.withW[k]), vfloat<K>(unitUlps * floatUlp));

    vfloat<K> tauIn(neg_inf), tauOut(pos_inf);
    vbool<K> outside(false);
    for (int k = 0; k < 3; k++) {
      clip(O[k] + epsilon[k], dO[k], tauIn, tauOut, outside);
      clip((O[3] - O[k]) + epsilon[k], dO[3] - dO[k], tauIn, tauOut, outside);
    }
    const vfloat<K> tauNear = state.scaledTnear - tref, tauFar = msub(state.tfar, state.rcpScale, tref);
    const vfloat<K> tau0 = max(tauIn, tauNear), tau1 = min(tauOut, tauFar);
    const vbool<K> intersects = andn(valid & (tau0 <= min(tau1, msub(nearestT, state.rcpScale, tref))), outside);
    if (none(intersects)) return intersects;
    startClipped = tauNear > tauIn;
    endClipped = tauFar < tauOut;
    w0 = madd(tau0, dO[3], O[3]);
    w1 = madd(tau1, dO[3], O[3]);
    t0 = tref + tau0;
    t1 = tref + tau1;
    const vfloat<K> divisor0 = nonZero(w0), divisor1 = nonZero(w1), least = nonZero(vfloat<K>(min(w0, w1)));
    for (int k = 0; k < 3; k++)
      setAxis(k, madd(tau0, dO[k], O[k]) / divisor0, madd(tau1, dO[k], O[k]) / divisor1, epsilon[k] / least);
    return intersects & (w0 > vfloat<K>(zero)) & (w1 > vfloat<K>(zero));
  }

  /*! See LocalRay::parameterAfter. */
  __forceinline vfloat<K> parameterAfter(const vfloat<K>& rcpScale, const vfloat<K>& t) const {
    const vfloat<K> at = product(t, rcpScale), tau = (at - t0) / nonZero(vfloat<K>(t1 - t0)), tw = product(tau, w1);
    return select(at < t1, tw / (product(w0, vfloat<K>(1.0f) - tau) + tw), vfloat<K>(1.0f)) + vfloat<K>(slackOfS);
  }
  /*! Same for ray k. */
  __forceinline float parameterAfter(size_t k, float rcpScale, float t) const {
    return localParameter(t0[k], t1[k], w0[k], w1[k], product(t, rcpScale)) + slackOfS;
  }

private:
  /*! Clips the range from tauIn to tauOut to a + tau d >= 0. Adds rays to `outside` as LocalRay::Clip does. */
  static __forceinline void clip(const vfloat<K>& a, const vfloat<K>& d, vfloat<K>& tauIn, vfloat<K>& tauOut,
                                 vbool<K>& outside) {
    const vfloat<K> r = -a / nonZero(d);
    tauIn = max(tauIn, select(d > vfloat<K>(zero), r, vfloat<K>(neg_inf)));
    tauOut = min(tauOut, select(d < vfloat<K>(zero), r, vfloat<K>(pos_inf)));
    outside |= (d == vfloat<K>(zero)) & (a < vfloat<K>(zero));
  }

  __forceinline void setAxis(int k, const vfloat<K>& from, const vfloat<K>& to, const vfloat<K>& epsilon) {
    P[k] = from;
    D[k] = to - from;
    descends[k] = D[k] < vfloat<K>(zero);
    const vfloat<K> outwards = select(descends[k], -epsilon, epsilon);
    Pnear[k] = from + outwards;
    Pfar[k] = from - outwards;
    const vfloat<K> away = vfloat<K>(1.0f) / max(abs(D[k]), vfloat<K>(1e-18f));
    rcpD[k] = select(descends[k], -away, away);
    if (k == 2) epsilonZ = epsilon;
  }
};

/*! Values of s, not clamped, at which the lines of rays enter and leave a box widened by epsilon. enterXY and
 *  leaveXY ignore z; enterZ and leaveZ ignore x and y. */
template<int K>
struct BoxRangesK {
  vfloat<K> enterXY, leaveXY, enterZ, leaveZ, sNear, sFar;

  /*! flipXY: see NodeRay. Lanes of rays with another flipXY become undefined. i: box. */
  template<int N>
  __forceinline void set(const NodeRays<K>& rays, uint32_t flipXY, const NodePlanes<N>& c, uint32_t i) {
    const uint32_t x = flipXY & 1u, y = flipXY >> 1;
    const vfloat<K> lowest(c.planes[2][0][i]), highest(c.planes[2][1][i]);
    enterXY = max((vfloat<K>(c.planes[0][x][i]) - rays.Pnear[0]) * rays.rcpD[0],
                  (vfloat<K>(c.planes[1][y][i]) - rays.Pnear[1]) * rays.rcpD[1]);
    leaveXY = min((vfloat<K>(c.planes[0][x ^ 1u][i]) - rays.Pfar[0]) * rays.rcpD[0],
                  (vfloat<K>(c.planes[1][y ^ 1u][i]) - rays.Pfar[1]) * rays.rcpD[1]);
    enterZ = (select(rays.descends[2], highest, lowest) - rays.Pnear[2]) * rays.rcpD[2];
    leaveZ = (select(rays.descends[2], lowest, highest) - rays.Pfar[2]) * rays.rcpD[2];
    sNear = max(enterXY, enterZ);
    sFar = min(leaveXY, leaveZ);
  }

  /*! Rays whose segment up to sBest intersects the box. */
  __forceinline vbool<K> intersects(const vfloat<K>& sBest) const {
    return max(sNear, vfloat<K>(zero)) <= min(sFar, sBest);
  }
  /*! Rays whose segment up to sBest intersects the box or passes over or under it. */
  __forceinline vbool<K> overlapsXY(const vfloat<K>& sBest) const {
    return max(enterXY, vfloat<K>(zero)) <= min(leaveXY, sBest);
  }

  /*! See NodeRay::isAbove. */
  __forceinline vbool<K> isAbove(const vbool<K>& descendsZ) const {
    return (leaveZ < max(enterXY, vfloat<K>(zero))) ^ descendsZ;
  }
};
} // namespace embree::isa::cbvh
