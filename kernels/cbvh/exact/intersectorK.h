// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Intersector of cVERT blocks for packets. Interval arithmetic over the rays of a class (VertRays::rayClass) culls
 * boxes of groups. The remaining boxes are tested with one ray per lane, and so are triangles that many rays reach. */

#include "intersector1.h"
#include "hitsK.h"

namespace embree::isa::cbvh {
template<int K, typename Rays>
class VertIntersectorK {
public:
  /*! Returns the rays that accepted a hit. Any-hit rays end at their first accepted hit. */
  static __noinline vbool<K> intersect(const vbool<K>& valid, Rays& rays, IntersectContext* context,
                                       VertRays<K>& vertRays, const VertHeader* block) {
    vertRays.set(rays);
    return VertIntersectorK(rays, context, vertRays, block).run(valid);
  }

private:
  /*! Up to this number of rays, each tests a group's triangles separately, with quads in lanes. More rays test
   *  them together, with rays in lanes. */
  static const size_t maxSeparateRays = vectorWidth == K ? 3 : 2;

  __forceinline VertIntersectorK(Rays& rays, IntersectContext* context, VertRays<K>& vertRays, const VertHeader* block)
    : rays(rays),
      context(context),
      vertRays(vertRays),
      block(block),
      cached(vertRays, block),
      found(0) {}

  __forceinline vbool<K> run(vbool<K> valid) {
    vint<K> rayClass = vertRays.rayClass;
    if (unlikely(cached.decodedBoxes() == nullptr)) {
      if (!cached.isValid()) return vbool<K>(false);
      if (likely(!isRaw(block->info))) valid &= intersectsBounds<vfloat<K>>(vertRays, block, rays.tnear(), rays.tfar);
      if (none(valid)) return valid;
    }
    const GroupBoxes& boxes = cached.boxes();
    if (likely(boxes.shearedAxis < 3)) {
      sheared = ShearedRay<vfloat<K>>(vertRays, boxes);
      rayClass |= select(sheared.rcp < vfloat<K>(zero), vint<K>(32), vint<K>(zero));
    }
    for (uint32_t rest = uint32_t(movemask(valid)); rest;) {
      const uint32_t k = uint32_t(bsf(rest));
      const uint32_t same = rest & uint32_t(movemask(rayClass == vint<K>(rayClass[k])));
      rest &= ~same;
      intersectTogether(same, uint32_t(rayClass[k]));
    }
    return vbool<K>(int(found));
  }

  /*! Components of rays on one axis of the boxes, with one sign of the direction, and bounds over the class. */
  struct Axis {
    vfloat<K> org, rcp, slack; //!< slack: in ray distances, `error` (the offset of planes) times |rcp|
    float orgLow, orgHigh, rcpLow, rcpHigh, slackHigh;
    bool isNegative;

    __forceinline void set(const vbool<K>& lanes, const vfloat<K>& org, const vfloat<K>& rcp, const vfloat<K>& error,
                           bool isNegative) {
      this->org = org;
      this->rcp = rcp;
      this->isNegative = isNegative;
      slack = error * abs(rcp);
      orgLow = lowest(lanes, org);
      orgHigh = highest(lanes, org);
      rcpLow = lowest(lanes, rcp);
      rcpHigh = highest(lanes, rcp);
      slackHigh = highest(lanes, slack);
    }

    __forceinline const float* nearPlanes(const GroupPlanes& planes) const { return planes.at[isNegative]; }
    __forceinline const float* farPlanes(const GroupPlanes& planes) const { return planes.at[!isNegative]; }

    /*! Lower bound of all rays' entry distances, one box per lane; leave(): upper bound of their exit distances.
     *  Rounding is monotonic, so no ray enters earlier or leaves later. */
    __forceinline vfloatV enter(const vfloatV& planes) const {
      const vfloatV d = planes - vfloatV(isNegative ? orgLow : orgHigh), slack(slackHigh);
      return min(msub(d, vfloatV(rcpLow), slack), msub(d, vfloatV(rcpHigh), slack));
    }
    __forceinline vfloatV leave(const vfloatV& planes) const {
      const vfloatV d = planes - vfloatV(isNegative ? orgHigh : orgLow), slack(slackHigh);
      return max(madd(d, vfloatV(rcpLow), slack), madd(d, vfloatV(rcpHigh), slack));
    }

  private:
    static __forceinline float lowest(const vbool<K>& lanes, const vfloat<K>& x) {
      return reduce_min(select(lanes, x, vfloat<K>(pos_inf)));
    }
    static __forceinline float highest(const vbool<K>& lanes, const vfloat<K>& x) {
      return reduce_max(select(lanes, x, vfloat<K>(neg_inf)));
    }
  };

  /*! Intersects the block with rays of the same class. rayClass: see VertRays. Bit 5 is set if the direction
   *  along the sheared axis is negative. */
  void intersectTogether(uint32_t mask, uint32_t rayClass) {
    vbool<K> lanes = vbool<K>(int(mask));
    const GroupBoxes& boxes = cached.boxes();
    for (int k = 0; k < 3; k++) {
      if (k == boxes.shearedAxis) axes[k].set(lanes, sheared.org, sheared.rcp, sheared.slack, (rayClass & 32u) != 0);
      else
        axes[k].set(lanes, vertRays.org[k], vertRays.rcp[k],
                    boxSlack<vfloat<K>>(vertRays.org[k], boxes.origin[k], boxes.extent[k]), (rayClass >> (2 + k)) & 1u);
    }
    uint32_t groups = intersectBoxes(lanes, boxes);
    while (groups) {
      const uint32_t g = IsAnyHit<Rays>::value ? popAny(groups) : popNearest(groups, enter);
      const vbool<K> entering = lanes & intersectBox(cached.boxes(), g);
      if (none(entering)) continue;
      const uint32_t accepted = intersectGroup(uint32_t(movemask(entering)), rayClass & 3u, g);
      found |= accepted;
      if (IsAnyHit<Rays>::value && accepted) {
        lanes = andn(lanes, vbool<K>(int(accepted)));
        if (none(lanes)) return;
      }
    }
  }

  /*! Mask of groups whose boxes some ray may intersect. Sets `enter`. */
  __forceinline uint32_t intersectBoxes(const vbool<K>& lanes, const GroupBoxes& boxes) {
    const float tnear = reduce_min(select(lanes, rays.tnear(), vfloat<K>(pos_inf))),
                tfar = reduce_max(select(lanes, rays.tfar, vfloat<K>(neg_inf)));
    uint32_t groups = 0;
    for (int j = 0; j < 16; j += vectorWidth) {
      vfloatV tNear(tnear), tFar(tfar);
      for (int k = 0; k < 3; k++) {
        tNear = max(tNear, axes[k].enter(vfloatV::load(axes[k].nearPlanes(boxes.planes[k]) + j)));
        tFar = min(tFar, axes[k].leave(vfloatV::load(axes[k].farPlanes(boxes.planes[k]) + j)));
      }
      vfloatV::store(enter + j, tNear);
      groups |= uint32_t(movemask(tNear <= tFar)) << j;
    }
    return groups & boxes.lanes;
  }

  /*! Returns the rays that intersect the box of group g. */
  __forceinline vbool<K> intersectBox(const GroupBoxes& boxes, uint32_t g) const {
    vfloat<K> tNear = rays.tnear(), tFar = rays.tfar;
    for (int k = 0; k < 3; k++) {
      const Axis& axis = axes[k];
      tNear = max(tNear, msub(vfloat<K>(axis.nearPlanes(boxes.planes[k])[g]) - axis.org, axis.rcp, axis.slack));
      tFar = min(tFar, madd(vfloat<K>(axis.farPlanes(boxes.planes[k])[g]) - axis.org, axis.rcp, axis.slack));
    }
    return tNear <= tFar;
  }

  /*! Returns the mask of rays that accepted a hit in group g. mask: rays that intersect its box. kz: see
   *  VertRay. */
  __forceinline uint32_t intersectGroup(uint32_t mask, uint32_t kz, uint32_t g) {
    VertHitsK<K, Rays> hits(rays, context, vertRays, block, cached);
    if (popcnt(mask) <= maxSeparateRays) {
      uint32_t accepted = 0;
      for (uint32_t rest = mask; rest; rest &= rest - 1) {
        const uint32_t k = uint32_t(bsf(rest));
        const GroupTriangles triangles(vertRays.ray(k), cached.vertices(g));
        if (triangles.mask && hits.report(k, g, triangles)) accepted |= 1u << k;
      }
      return accepted;
    }
    const GroupTrianglesK<K> triangles(vertRays, kz, cached.vertices(g));
    mask &= uint32_t(movemask(triangles.mask != vint<K>(zero)));
    return mask ? hits.report(mask, kz, g, triangles.mask) : 0u;
  }

  Rays& rays;
  IntersectContext* context;
  VertRays<K>& vertRays;
  const VertHeader* block;
  const CachedVertBlock cached;
  ShearedRay<vfloat<K>> sheared;
  Axis axes[3];
  uint32_t found;              //!< rays that accepted a hit
  alignas(64) float enter[16]; //!< lower bound of entry distances, by the group's lane
};
} // namespace embree::isa::cbvh
