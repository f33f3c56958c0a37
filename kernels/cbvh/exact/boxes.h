// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays in the coordinates of a cVERT block's boxes, and tests against the bounds of the entire block, which need only
 * its header. Boxes must not reject a ray that hits a triangle: planes are moved outward by the rounding errors of
 * cvert/rule/rule.h. `Real` is float, or a vector with one ray of a packet per lane. */

#include "box_decoder.h"
#include "ray.h"
#include "../../cvert/format/motion.h"

namespace embree::isa::cbvh {
/*! A ray on the sheared axis. org: relative to the block's origin. slack: outward offset of planes. */
template<typename Real>
struct ShearedRay {
  Real org, rcp, slack;

  __forceinline ShearedRay() {}

  __forceinline ShearedRay(const VertRayBase<Real>& ray, const VertAxes& axes) {
    ShearedCoordinate<Real> along = zeroShearedCoordinate<Real>();
    for (int k = 0; k < 3; k++)
      along = addSheared(along, ray.org[k], ray.dir[k], axes.origin[k], axes.extent[k], axes.shear[k]);
    org = along.org;
    rcp = directionReciprocal(along.dir, ray.largestComponent);
    slack = shearedSlack(along.size);
  }
};

/*! boxSlack and ShearedRay of a single ray, for all axes at once. Vector loads from arrays of three floats also
 *  read the next member, into an unused lane. */
struct RayInBoxes {
  alignas(16) float slack[4];      //!< boxSlack times |rcp|, by axis
  alignas(16) float coordinate[4]; //!< ShearedCoordinate: org, dir and size

  __forceinline RayInBoxes(const VertRayBase<float>& ray, const GroupBoxes& boxes) {
    const vfloat4 distance = vfloat4::loadu(ray.org) - vfloat4::loadu(boxes.origin);
    const vfloat4 farthest = abs(distance) + vfloat4::loadu(boxes.extent),
                  shear = withoutFourth(vfloat4::loadu(boxes.shear)); // which is followed by an integer
    vfloat4::store(slack, vfloat4(slackUlps * floatUlp) * farthest * abs(vfloat4::loadu(ray.rcp)));
    vfloat4 x, y, z;
    transpose(shear * distance, shear * vfloat4::loadu(ray.dir), abs(shear) * farthest, vfloat4(zero), x, y, z);
    vfloat4::store(coordinate, x + y + z);
  }

  __forceinline ShearedRay<float> sheared(const VertRayBase<float>& ray) const {
    ShearedRay<float> along;
    along.org = coordinate[0];
    along.rcp = directionReciprocal(coordinate[1], ray.largestComponent);
    along.slack = shearedSlack(coordinate[2]);
    return along;
  }
};

/*! Bounds of a block relative to its origin, see ShearedBounds. */
struct BlockBounds : public VertAxes, public ShearedBounds {
  float slack[3]; //!< further outward offset of planes, by axis: rounding of interpolated bounds
};

/*! Returns false if the ray misses the bounds between tNear and tFar. */
template<typename Real>
__forceinline auto intersectsBounds(const VertRayBase<Real>& ray, const BlockBounds& bounds, Real tNear, Real tFar)
    -> decltype(tNear <= tFar) {
  const int m = bounds.shearedAxis;
  RayInterval<Real> interval = {tNear, tFar};
  for (int i = 0; i < 2; i++) {
    const int k = axisAfter(m, 1 + i);
    const Real from = Real(bounds.origin[k]) - ray.org[k],
               slack = boxSlack(ray.org[k], bounds.origin[k], bounds.extent[k]) + Real(bounds.slack[k]);
    interval = clipInterval(interval, from - slack, (from + Real(bounds.upper[i])) + slack, ray.rcp[k]);
  }
  const ShearedRay<Real> sheared(ray, bounds);
  const Real slack = sheared.slack + Real(bounds.slack[m]);
  interval = clipInterval(interval, (Real(bounds.sheared[0]) - sheared.org) - slack,
                          (Real(bounds.sheared[1]) - sheared.org) + slack, sheared.rcp);
  return interval.from <= interval.to;
}

/*! As above, with the bounds in the header of a block that does not move. Requires !isRaw(block->info). */
template<typename Real>
__forceinline auto intersectsBounds(const VertRayBase<Real>& ray, const VertHeader* block, Real tNear, Real tFar)
    -> decltype(tNear <= tFar) {
  BlockBounds bounds;
  setShear(block->info, true, bounds);
  static_cast<ShearedBounds&>(bounds) =
      decodeBounds(block->info, block->bounds, boundsUnit(block->info), spacingOf(block->word, block->corners));
  const float extent = extentOfBounds(bounds);
  for (int k = 0; k < 3; k++) {
    bounds.origin[k] = block->origin[k];
    bounds.extent[k] = extent;
  }
  for (float& slack : bounds.slack) slack = 0.0f;
  return intersectsBounds<Real>(ray, bounds, tNear, tFar);
}

/*! Bounds of a moving block between two time steps. Reads only the headers of the steps. */
class SegmentBounds {
  struct End {
    const float* origin;
    VertSpacing spacing;
    uint32_t bounds, boundsUnit; //!< encoded bounds, and their unit
  };
  End ends[2];
  uint32_t info;

public:
  bool raw; //!< an end is raw; the segment has no bounds

  __forceinline SegmentBounds(const VertHeader* block, uint32_t segment) {
    const VertStep* const end = stepOf(block, segment + 1);
    if (likely(segment == 0)) {
      info = block->info;
      set(ends[0], block->origin, spacingOf(block->word, block->corners), boundsUnit(info), block->bounds);
    } else {
      const VertStep* const begin = stepOf(block, segment);
      info = begin->info;
      set(ends[0], begin->origin, spacingOf(begin->word, begin->corners), beginBoundsUnit(info), begin->bounds);
    }
    set(ends[1], end->origin, spacingOf(end->word, end->corners), endBoundsUnit(end->rotation), end->endBounds);
    raw = isRaw(info) || isRaw(end->info);
  }

  /*! VertAxes::extent for all times in the segment. Requires !raw. */
  __forceinline float extent() const {
    return max(extentOfBounds(boundsOf(ends[0])), extentOfBounds(boundsOf(ends[1])));
  }

  /*! Sets the bounds at fraction f of the segment, 0 to 1. Requires !raw. */
  __forceinline void set(float f, BlockBounds& out) const {
    setShear(info, true, out);
    const ShearedBounds begin = boundsOf(ends[0]), end = boundsOf(ends[1]);
    static_cast<ShearedBounds&>(out) = interpolateBounds(begin, end, f);
    const float e = 1.0f - f, extent = max(extentOfBounds(begin), extentOfBounds(end));
    float sheared = 0.0f;
    for (int k = 0; k < 3; k++) {
      out.origin[k] = e * ends[0].origin[k] + f * ends[1].origin[k];
      out.extent[k] = extent;
      out.slack[k] = motionSlack(ends[0].origin[k], ends[1].origin[k], extent);
      sheared += std::fabs(out.shear[k]) * out.slack[k];
    }
    out.slack[out.shearedAxis] = sheared;
  }

private:
  static __forceinline void set(End& end, const float* origin, const VertSpacing& spacing, uint32_t boundsUnit,
                                uint32_t bounds) {
    end.origin = origin;
    end.spacing = spacing;
    end.boundsUnit = boundsUnit;
    end.bounds = bounds;
  }

  __forceinline ShearedBounds boundsOf(const End& end) const {
    return decodeBounds(info, end.bounds, end.boundsUnit, end.spacing);
  }
};
} // namespace embree::isa::cbvh
