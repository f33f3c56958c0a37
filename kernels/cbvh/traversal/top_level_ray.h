// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays in the top-level BVH, and tests that cull rays before its traversal. Rays differ from Embree's in two ways:
 *
 * Rays that are not finite are rejected. Comparisons with NaN would report hits of nonexistent children, and make a
 * packet's bounds useless.
 *
 * Embree replaces reciprocals of components below 1e-18 by 1e18, whatever the length of the direction. For a length of
 * 1e-12 and a component of 0, this tilts the ray by 1e-6, so that it misses boxes of geometry that it hits. Here the
 * threshold is relative to the largest component (cvert/rule/reciprocal.h), and reciprocals are never 0. Traversal of
 * finite rays and boxes computes no NaN, and no ray hits nonexistent children, whose bounds are infinity to
 * -infinity. */

#include "../base/vectors.h"
#include "../embree/traversal.h"
#include <limits>

namespace embree::isa::cbvh {
/*! True if origin and direction are finite, and tnear <= tfar. Other rays hit nothing. */
__forceinline bool isValidRay(const Ray& ray, const vfloat4& org, const vfloat4& dir) {
  const vfloat4 bound(pos_inf);
  const bool isRange = ray.tnear() <= ray.tfar;
  return all((abs(org) < bound) & (abs(dir) < bound)) & isRange;
}
__forceinline bool isValidRay(const Ray& ray) { return isValidRay(ray, loadOfRay(&ray.org.x), loadOfRay(&ray.dir.x)); }

template<int K>
__forceinline vbool<K> isValidRay(const RayK<K>& rays) {
  vbool<K> finite = rays.tnear() <= rays.tfar;
  for (int axis = 0; axis < 3; axis++)
    finite &= (abs(rays.org[axis]) < vfloat<K>(pos_inf)) & (abs(rays.dir[axis]) < vfloat<K>(pos_inf));
  return finite;
}

/*! Factors of reciprocals for the distances at which rays enter and leave boxes: 3 ulps as in Embree, so that
 *  grids of GRID have the hits that they have in Embree's own tree. No lost ray is known. A proof that traversal
 *  culls no box of a triangle that cvert/rule/rule.h hits in front of the ray would need 3.5 ulps: 7 half ulps
 *  of the hit's distance on the direction's largest axis. 2 are for the shear of the other axes, at most 2 for
 *  rounding sheared vertices, and 3 for the distance to a plane (reciprocal, factor, product). Subtracting the
 *  origin adds none, because planes and vertices round the same way. */
static constexpr float nearFactor = 1.0f - 3.0f * std::numeric_limits<float>::epsilon();
static constexpr float farFactor = 1.0f + 3.0f * std::numeric_limits<float>::epsilon();

/*! Reciprocals of a direction, by axis, and as factors of Embree's robust traversal. */
struct PlaneFactors {
  const vfloat4 rdir, near, far;

  /*! dir: the fourth lane as in directionReciprocals. */
  __forceinline explicit PlaneFactors(const vfloat4& dir)
    : rdir(directionReciprocals(dir)),
      near(vfloat4(nearFactor) * rdir),
      far(vfloat4(farFactor) * rdir) {}
};

/*! Returns false if the ray misses a box and, with the rounding of traversal, all boxes inside of it. Requires
 *  isValidRay(). */
__forceinline bool mayIntersect(const Ray& ray, const BBox3fa& box) {
  const PlaneFactors factors(loadOfRay(&ray.dir.x));
  const vbool4 isNegative = factors.rdir < vfloat4(zero);
  const vfloat4 org = loadOfRay(&ray.org.x), lower(box.lower.m128), upper(box.upper.m128);
  const Vec3fa entryT((select(isNegative, upper, lower) - org) * factors.near),
      exitT((select(isNegative, lower, upper) - org) * factors.far);
  return max(reduce_max(entryT), max(ray.tnear(), 0.0f)) <= min(reduce_min(exitT), max(ray.tfar, 0.0f));
}

template<int K>
__forceinline vbool<K> mayIntersect(const RayK<K>& rays, const BBox3fa& box) {
  const vfloat<K> largest = max(max(abs(rays.dir.x), abs(rays.dir.y)), abs(rays.dir.z));
  vfloat<K> entryT = max(rays.tnear(), vfloat<K>(zero)), exitT = max(rays.tfar, vfloat<K>(zero));
  for (int axis = 0; axis < 3; axis++) {
    const vfloat<K> rdir = directionReciprocal(rays.dir[axis], largest), lower(box.lower[axis]), upper(box.upper[axis]);
    const vbool<K> isNegative = rdir < vfloat<K>(zero);
    entryT = max(entryT, (select(isNegative, upper, lower) - rays.org[axis]) * (vfloat<K>(nearFactor) * rdir));
    exitT = min(exitT, (select(isNegative, lower, upper) - rays.org[axis]) * (vfloat<K>(farFactor) * rdir));
  }
  return entryT <= exitT;
}

/*! Embree's ray of robust traversal, with other reciprocals. nearX to farZ: byte offsets of a node's planes. */
struct TopLevelRay : public TravRay<4, true> {
  __forceinline explicit TopLevelRay(const Ray& ray) {
    const vfloat4 o = loadOfRay(&ray.org.x), d = loadOfRay(&ray.dir.x);
    const PlaneFactors factors(d);
    const vfloat4 near = factors.near, far = factors.far;
    org_xyz = Vec3fa(o);
    dir_xyz = Vec3fa(d);
    org = Vec3vf<4>(shuffle<0>(o), shuffle<1>(o), shuffle<2>(o));
    dir = Vec3vf<4>(shuffle<0>(d), shuffle<1>(d), shuffle<2>(d));
    rdir_near = Vec3vf<4>(shuffle<0>(near), shuffle<1>(near), shuffle<2>(near));
    rdir_far = Vec3vf<4>(shuffle<0>(far), shuffle<1>(far), shuffle<2>(far));
    const size_t negativeAxes = size_t(movemask(factors.rdir < vfloat4(zero)));
    nearX = sizeof(vfloat4) * (0 + (negativeAxes & 1));
    nearY = sizeof(vfloat4) * (2 + ((negativeAxes >> 1) & 1));
    nearZ = sizeof(vfloat4) * (4 + ((negativeAxes >> 2) & 1));
    farX = nearX ^ sizeof(vfloat4);
    farY = nearY ^ sizeof(vfloat4);
    farZ = nearZ ^ sizeof(vfloat4);
    tnear = max(ray.tnear(), 0.0f);
    tfar = max(ray.tfar, 0.0f);
  }
};

/*! As TopLevelRay, for packets. Inactive lanes contain finite rays. The caller must set tnear and tfar. */
template<int K>
struct TopLevelRays : public TravRayK<K, true> {
  __forceinline TopLevelRays(const vbool<K>& valid, const RayK<K>& rays) {
    for (int axis = 0; axis < 3; axis++) {
      this->org[axis] = select(valid, rays.org[axis], vfloat<K>(zero));
      this->dir[axis] = select(valid, rays.dir[axis], vfloat<K>(one));
    }
    const vfloat<K> largest = max(max(abs(this->dir.x), abs(this->dir.y)), abs(this->dir.z));
    for (int axis = 0; axis < 3; axis++) {
      this->rdir[axis] = directionReciprocal(this->dir[axis], largest);
      this->nearXYZ[axis] = select(this->rdir[axis] < vfloat<K>(zero), vint<K>(int(sizeof(vfloat4)) * (2 * axis + 1)),
                                   vint<K>(int(sizeof(vfloat4)) * 2 * axis));
    }
  }
};
} // namespace embree::isa::cbvh
