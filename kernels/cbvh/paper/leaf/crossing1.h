// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* crossPatch() of crossing.h for a single ray and a decoded leaf. */

#include "../block_visitor1.h"
#include "crossing.h"

namespace embree::isa::cbvh {
/*! Returns (u,v), clamped to 0 to 1, at s[0] in lanes 0 and 1, at s[2] in lanes 2 and 3. Requires
 *  s[1] = s[0] and s[3] = s[2]. */
__forceinline vfloat4 positionInLeaf(const NodeRay& ray, const LeafSurfaces& surfaces, uint32_t leaf,
                                     const vfloat4& s) {
  const vfloat4 footprint = vfloat4::load(surfaces.footprint[leaf]);
  const vfloat4 P = vfloat4(_mm_movelh_ps(ray.P, ray.P)), D = vfloat4(_mm_movelh_ps(ray.D, ray.D));
  const vfloat4 at =
      (madd(s, D, P) - vfloat4(_mm_movelh_ps(footprint, footprint))) * vfloat4(_mm_movehl_ps(footprint, footprint));
  return max(min(at, vfloat4(one)), vfloat4(zero));
}

/*! ranges: of the box test. started, ended: see LeafEvent. */
__forceinline Crossing<float> crossDecodedLeaf(const NodeRay& ray, const NodeEntries::LeafTile& tile, uint32_t leaf,
                                               const BoxRanges<16>& ranges, bool started, bool ended) {
  const LeafSurfaces& surfaces = tile.surfaces;
  const float sNear = ranges.sNear[leaf], sFar = ranges.sFar[leaf];
  Crossing<float> x;
  x.s0 = max(sNear, 0.0f);
  x.s1 = min(sFar, 1.0f);
  const vfloat4 uv = positionInLeaf(ray, surfaces, leaf, vfloat4(x.s0, x.s0, x.s1, x.s1));
  x.u0 = uv[0];
  x.v0 = uv[1];
  x.u1 = uv[2];
  x.v1 = uv[3];
  const vfloat4 h = vfloat4::load(surfaces.height[leaf]);
  const vfloat4 u = shuffle<0, 2, 0, 2>(uv), v = shuffle<1, 3, 1, 3>(uv);
  const vfloat4 patch = madd(u, shuffle<1>(h), madd(v, madd(u, shuffle<3>(h), shuffle<2>(h)), shuffle<0>(h)));
  const vfloat4 above = madd(vfloat4(x.s0, x.s1, x.s0, x.s1), shuffle<2>(ray.D), shuffle<2>(ray.P)) - patch;
  x.f.f0 = above[0];
  x.f.f1 = above[1];
  x.f.saddle = h[3] * (x.u1 - x.u0) * (x.v1 - x.v0);

  x.event.solid = (surfaces.solid >> leaf) & 1u;
  x.event.empty = (surfaces.empty >> leaf) & 1u;
  x.event.started = started;
  x.event.ended = ended;
  bool above0 = x.f.f0 >= 0.0f, above1 = x.f.f1 >= 0.0f;
  x.event.changes = above0 != above1;
  if (ray.entryS(tile.grandchildren, 2, leaf) >= sNear && !started) above0 = ray.descends();
  if (ray.exitS(tile.grandchildren, 2, leaf) <= sFar && !ended) above1 = !ray.descends();
  x.event.enter = above0 ? sideAbove : sideBelow;
  x.event.leave = above1 ? sideAbove : sideBelow;
  const float tolerance = surfaces.halfThickness[leaf] + ray.epsilonZ;
  const float f0 = std::fabs(x.f.f0), f1 = std::fabs(x.f.f1);
  x.event.nearEntry = f0 <= tolerance;
  x.event.near = x.event.changes || min(f0, f1) <= fused(0.25f, std::fabs(x.f.saddle), tolerance);
  return x;
}
} // namespace embree::isa::cbvh
