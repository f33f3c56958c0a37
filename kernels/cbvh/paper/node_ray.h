// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A LocalRay prepared for tests of the boxes of nodes, four or more boxes at a time. */

#include "local_ray4.h"
#include "node_cache.h"

namespace embree::isa::cbvh {
/*! A segment P + s D in the frame of a block, with s from 0 to 1. */
struct NodeRay {
  vfloat4 P, D;
  vfloatV Pnear[3], Pfar[3]; //!< P moved by epsilon, which widens boxes; the same in all lanes
  vfloatV rcpD[3];
  float epsilonZ;    //!< epsilon along z, see local_ray.h
  uint32_t flip;     //!< bit k: the ray descends along axis k
  size_t nearRow[3]; //!< 16 times the row of the near planes in NodePlanes

  __forceinline NodeRay(const LocalRay& ray) {
    P = ray.P0;
    D = ray.P1 - ray.P0;
    const vboolf4 down = D < vfloat4(zero);
    const vfloat4 outwards = select(down, -ray.epsilon, ray.epsilon);
    const vfloat4 n = P + outwards, f = P - outwards;
    // the limit keeps reciprocals finite
    const vfloat4 away = vfloat4(1.0f) / max(abs(D), vfloat4(1e-18f));
    const vfloat4 r = select(down, -away, away);
    epsilonZ = ray.epsilon[2];
    flip = uint32_t(movemask(down)) & 7u;
    for (int k = 0; k < 3; k++) {
      Pnear[k] = vfloatV(n[k]);
      Pfar[k] = vfloatV(f[k]);
      rcpD[k] = vfloatV(r[k]);
      nearRow[k] = 16 * (2 * k + nearSide(k));
    }
  }

  /*! Number of the first child (column + 2 row) along the ray. */
  __forceinline uint32_t flipXY() const { return flip & 3u; }
  /*! True if the ray descends along z. */
  __forceinline bool descends() const { return (flip & 4u) != 0u; }

  /*! 1 if upper planes of an axis are near. */
  __forceinline uint32_t nearSide(int axis) const { return (flip >> axis) & 1u; }

  /*! Planes through which the ray enters boxes, one per box. N/4 converts nearRow to bytes. */
  template<int N>
  __forceinline const float* nearPlanes(const NodePlanes<N>& c, int axis) const {
    return (const float*)((const char*)&c + nearRow[axis] * (N / 4));
  }
  template<int N>
  __forceinline const float* farPlanes(const NodePlanes<N>& c, int axis) const {
    return (const float*)((const char*)&c + (nearRow[axis] ^ 16) * (N / 4));
  }

  /*! s at the widened near plane (entryS) or far plane (exitS) of box i. */
  template<int N>
  __forceinline float entryS(const NodePlanes<N>& c, int axis, uint32_t i) const {
    return (nearPlanes(c, axis)[i] - Pnear[axis][0]) * rcpD[axis][0];
  }
  template<int N>
  __forceinline float exitS(const NodePlanes<N>& c, int axis, uint32_t i) const {
    return (farPlanes(c, axis)[i] - Pfar[axis][0]) * rcpD[axis][0];
  }

  /*! True if the ray passes over a box that it misses but overlaps in x and y. */
  template<int N>
  __forceinline bool isAbove(const NodePlanes<N>& c, uint32_t i) const {
    const float nxy = max(entryS(c, 0, i), entryS(c, 1, i));
    return (exitS(c, 2, i) < max(nxy, 0.0f)) != descends();
  }
};

/*! Values of s, not clamped, at which the ray's line enters and leaves boxes. */
template<int N>
struct alignas(64) BoxRanges {
  float sNear[N], sFar[N];
};

struct BoxMasks {
  uint32_t hit;    //!< boxes that the segment intersects
  uint32_t passed; //!< boxes that the segment overlaps in x and y, but misses
};

/*! Tests the first `number` boxes against the segment up to sBest. Sets their `ranges`. number: a multiple of
 *  the lanes. */
template<typename vfloatW, int N>
__forceinline BoxMasks intersectBoxes(const NodeRay& ray, const NodePlanes<N>& c, float sBest, BoxRanges<N>& ranges,
                                      int number = N) {
  static_assert(int(vfloatW::size) <= vectorWidth, "the vectors of NodeRay have fewer lanes");
  /* copies: a compiler that assumes that the stores below modify the ray would load its members again */
  const float* nearPlanes[3];
  const float* farPlanes[3];
  vfloatW Pnear[3], Pfar[3], rcpD[3];
  for (int k = 0; k < 3; k++) {
    nearPlanes[k] = ray.nearPlanes(c, k);
    farPlanes[k] = ray.farPlanes(c, k);
    Pnear[k] = vfloatW::load((const float*)&ray.Pnear[k]);
    Pfar[k] = vfloatW::load((const float*)&ray.Pfar[k]);
    rcpD[k] = vfloatW::load((const float*)&ray.rcpD[k]);
  }
  BoxMasks masks = {0u, 0u};
  for (int i = 0; i < number; i += int(vfloatW::size)) {
    auto entryS = [&](int k) { return (vfloatW::load(nearPlanes[k] + i) - Pnear[k]) * rcpD[k]; };
    auto exitS = [&](int k) { return (vfloatW::load(farPlanes[k] + i) - Pfar[k]) * rcpD[k]; };
    const vfloatW nxy = max(entryS(0), entryS(1)), fxy = min(exitS(0), exitS(1));
    const vfloatW sNear = max(nxy, entryS(2)), sFar = min(fxy, exitS(2));
    vfloatW::store(ranges.sNear + i, sNear);
    vfloatW::store(ranges.sFar + i, sFar);
    masks.hit |= uint32_t(movemask(max(sNear, vfloatW(zero)) <= min(sFar, vfloatW(sBest)))) << i;
    masks.passed |= uint32_t(movemask(max(nxy, vfloatW(zero)) <= min(fxy, vfloatW(sBest)))) << i;
  }
  masks.passed &= ~masks.hit;
  return masks;
}
} // namespace embree::isa::cbvh
