// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersector of cVERT blocks and mesh blocks, at rest or moving: boxes of groups, then groups (front
 * to back for closest hits), then triangles. moving_intersector1.h has functions for moving ones. Packets also use
 * intersectGroupBoxes(), popNearest() and popAny(). */

#include "boxes.h"
#include "hits1.h"

namespace embree::isa::cbvh {
/*! A single ray as the Target of VertHitReporter. */
template<typename RayType>
struct VertTarget1 {
  RayType& ray;
  IntersectContext* context;

  __forceinline float tnear() const { return ray.tnear(); }
  __forceinline float tfar() const { return ray.tfar; }
  __forceinline const SurfaceIDs& ids() const { return context->scene->surfaceIDs; }
  __forceinline bool needsHitData(const VertHeader* block) const {
    return cbvh::needsHitData(ray, context, block->surface);
  }
  __forceinline bool report(const VertHeader* block, uint32_t primID, SurfaceHit1& hit) const {
    return cbvh::report(ray, context, block->surface, primID, hit);
  }
};

/*! Returns the mask of groups whose boxes the ray may intersect between tnear and tfar. enter: receives a lower
 *  bound of the entry distance per lane; aligned to vectors. vertRay: with the members for boxes, which
 *  VertRays::ray() does not set. */
__forceinline uint32_t intersectGroupBoxes(const VertRay& vertRay, float tnear, float tfar, const GroupBoxes& boxes,
                                           float enter[16]) {
  const int vectors = QuadCornersV::vectors;
  // GCC keeps arrays of four vectors in registers only if all loops over them are unrolled early
  vfloatV tNear[vectors], tFar[vectors];
#pragma GCC unroll 4
  for (int j = 0; j < vectors; j++) {
    tNear[j] = vfloatV(tnear);
    tFar[j] = vfloatV(tfar);
  }
  // isNegative: an index of planes, because a branch would often be mispredicted
  auto clip = [&](const GroupPlanes& planes, float from, float reciprocal, float slackOfPlanes, uint32_t isNegative) {
    const float* near = planes.at[isNegative];
    const float* far = planes.at[1 - isNegative];
    const vfloatV org(from), rcp(reciprocal), slack(slackOfPlanes);
#pragma GCC unroll 4
    for (int j = 0; j < vectors; j++) {
      tNear[j] = max(tNear[j], msub(vfloatV::load(near + vectorWidth * j) - org, rcp, slack));
      tFar[j] = min(tFar[j], madd(vfloatV::load(far + vectorWidth * j) - org, rcp, slack));
    }
  };
  const int m = boxes.shearedAxis;
  const RayInBoxes at(vertRay, boxes);
  for (int k = 0; k < 3; k++)
    if (k != m) clip(boxes.planes[k], vertRay.org[k], vertRay.rcp[k], at.slack[k], (vertRay.negativeAxes >> k) & 1u);
  if (likely(m < 3)) {
    const ShearedRay<float> sheared = at.sheared(vertRay);
    clip(boxes.planes[m], sheared.org, sheared.rcp, sheared.slack * std::fabs(sheared.rcp), sheared.rcp < 0.0f);
  }
  vboolV hit[vectors];
#pragma GCC unroll 4
  for (int j = 0; j < vectors; j++) {
    vfloatV::store(enter + vectorWidth * j, tNear[j]);
    hit[j] = tNear[j] <= tFar[j];
  }
  return movemasks(hit) & boxes.lanes;
}

/*! Removes the group with the smallest entry distance from a mask, and returns it. The mask must not be 0. */
__forceinline uint32_t popNearest(uint32_t& groups, const float enter[16]) {
  uint32_t best = uint32_t(bsf(groups));
  for (uint32_t rest = groups & (groups - 1); rest; rest &= rest - 1) {
    const uint32_t g = uint32_t(bsf(rest));
    if (enter[g] < enter[best]) best = g;
  }
  groups &= ~(1u << best);
  return best;
}

/*! Removes a group from a mask, which must not be 0, and returns it. */
__forceinline uint32_t popAny(uint32_t& groups) {
  const uint32_t g = uint32_t(bsf(groups));
  groups &= groups - 1;
  return g;
}

/*! Intersects a ray with groups of a block, the nearest ones first for closest hits. Target, Cached: see
 *  VertHitReporter. groups, enter: see intersectGroupBoxes. Returns true if a hit was accepted. */
template<bool isAnyHit, typename Target, typename Cached>
__forceinline bool intersectGroups(const Target& target, const VertRay& vertRay, NearestVertHit& nearest,
                                   const VertHeader* block, const Cached& cached, uint32_t groups,
                                   const float enter[16]) {
  VertHitReporter<Target, Cached> hits(target, vertRay, nearest, block, cached);
  bool found = false;
  while (groups) {
    const uint32_t g = isAnyHit ? popAny(groups) : popNearest(groups, enter);
    if (enter[g] > target.tfar()) continue;
    const auto triangles = groupTrianglesHitByLine(vertRay, cached, g);
    if (triangles.mask == 0 || !hits.report(g, triangles)) continue;
    if (isAnyHit) return true;
    found = true;
  }
  return found;
}

/*! Cached: CachedVertBlock, MovingVertBlock, CachedMeshBlock or MovingMeshBlock. */
template<typename RayType, typename Cached>
class VertIntersector1 {
public:
  /*! Returns true if a hit was accepted. Any-hit queries end at the first accepted hit. vertRay: one per ray, the
   *  same for all its blocks; the first call sets it. at: a moving block's TimeInMotion. */
  template<typename... At>
  static __forceinline bool intersect(RayType& ray, IntersectContext* context, VertRay& vertRay,
                                      const VertHeader* block, const At&... at) {
    vertRay.set(ray);
    return VertIntersector1(ray, context, vertRay, block, at...).run();
  }

private:
  template<typename... At>
  __forceinline VertIntersector1(RayType& ray, IntersectContext* context, const VertRay& vertRay,
                                 const VertHeader* block, const At&... at)
    : ray(ray),
      context(context),
      vertRay(vertRay),
      block(block),
      cached(vertRay, block, at...) {}

  __forceinline bool run() {
    const GroupBoxes* boxes = cached.decodedBoxes();
    if (unlikely(boxes == nullptr)) {
      if (!cached.isValid() || !cached.mayIntersect(vertRay, ray.tnear(), ray.tfar)) return false;
      boxes = &cached.boxes();
    }
    const uint32_t groups = intersectGroupBoxes(vertRay, ray.tnear(), ray.tfar, *boxes, enter);
    return intersectGroups<IsAnyHit<RayType>::value>(VertTarget1<RayType>{ray, context}, vertRay, vertRay.nearest,
                                                     block, cached, groups, enter);
  }

  RayType& ray;
  IntersectContext* context;
  const VertRay& vertRay;
  const VertHeader* block;
  const Cached cached;
  alignas(64) float enter[16]; //!< entry distance of each group's box
};

/* These functions return true if a hit was accepted. They are not inlined, so that traversal keeps its ray in
 * registers. */

template<typename RayType>
__noinline bool intersectVert(RayType& ray, IntersectContext* context, VertRay& vertRay, const VertHeader* block) {
  return VertIntersector1<RayType, CachedVertBlock>::intersect(ray, context, vertRay, block);
}

/*! block: a MeshHeader. traversal/mesh_intersector1.cpp defines the function for Ray and RayHit. */
template<typename RayType>
bool intersectMesh(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* block);

/*! The same for a mesh tile. */
template<typename RayType>
bool intersectMeshTile(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* tile);
} // namespace embree::isa::cbvh
