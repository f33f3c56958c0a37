// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Exact tests of a group's triangles that mayContain (cvert/rule/rule.h) accepted. */

#include "cached_block.h"
#include "triangles.h"
#include "../base/report_hit.h"

namespace embree::isa::cbvh {
/* Access to a group of a block. Cached: as in VertIntersector1; isMesh is true for mesh blocks. g: lane of the group.
 * index: of the triangle in the group, below 32; of cVERT blocks, see VertTables::triangles. */

template<typename Cached>
__forceinline SurfacePoint pointOfHit(const Cached& cached, const VertHeader* block, uint32_t g, uint32_t index,
                                      const VertTriangle::Sides& sides) {
  if constexpr (Cached::isMesh)
    return cached.point(g, index, clampParameter(sides.w1 / sides.sum), clampParameter(sides.w2 / sides.sum));
  else return surfacePoint(block, g, index, positionInQuad(sides, bool(index & 1)));
}

template<typename Cached>
__forceinline VertTriangle triangleOf(const Cached& cached, uint32_t g, uint32_t index) {
  if constexpr (Cached::isMesh) return meshTriangleOf(cached, g, index); // mesh_corners.h
  else return VertTriangle(cached.vertices(g), index);
}

template<typename Cached>
__forceinline auto groupTrianglesHitByLine(const VertRay& ray, const Cached& cached, uint32_t g) {
  if constexpr (Cached::isMesh) return meshTrianglesHitByLine(ray, cached, g); // mesh_corners.h
  else return GroupTriangles(ray, cached.vertices(g));
}

/*! GroupTriangles of one ray of a packet, without sides. */
struct TriangleMask {
  uint32_t mask;
};

/*! Sides of a triangle that the group's test stored. */
template<typename Triangles>
__forceinline VertTriangle::Sides sidesOf(const Triangles& triangles, const VertTriangle&, const VertRay&,
                                          uint32_t index) {
  return triangles.sides(index);
}
/*! As above, computed again. */
__forceinline VertTriangle::Sides sidesOf(const TriangleMask&, const VertTriangle& triangle, const VertRay& ray,
                                          uint32_t) {
  return triangle.sides(ray);
}

/*! Tests and reports hits of a ray in a block. Cached: as in VertIntersector1. Target: the ray, with
 *
 *    float tnear (), tfar ()
 *      Range of distances; an accepted closest hit sets tfar() to its distance.
 *    const SurfaceIDs& ids ()
 *      Of the scene.
 *    bool needsHitData (block)
 *      See base/report_hit.h.
 *    bool report (block, primID, hit)
 *      Returns true if the hit is accepted. */
template<typename Target, typename Cached>
class VertHitReporter {
public:
  __forceinline VertHitReporter(const Target& target, const VertRay& vertRay, NearestVertHit& nearest,
                                const VertHeader* block, const Cached& cached)
    : target(target),
      vertRay(vertRay),
      nearest(nearest),
      block(block),
      cached(cached) {}

  /*! Reports hits in group g until one is accepted, nearest first if the target needs their data. Returns true if
   *  one was. triangles.mask must not be 0. */
  template<typename Triangles>
  __forceinline bool report(uint32_t g, const Triangles& triangles) {
    const uint32_t mask = triangles.mask;
    if (!target.needsHitData(block)) return reportAny(g, triangles);
    if (likely((mask & (mask - 1)) == 0)) {
      const uint32_t index = uint32_t(bsf(mask));
      const VertTriangle triangle = triangleOf(cached, g, index);
      const VertTriangle::Sides sides = sidesOf(triangles, triangle, vertRay, index);
      const WideNormal<double> normal = triangle.normal();
      float t;
      return triangle.contains(vertRay, sides) &&
             isInRange(triangle.distance(vertRay, normal, target.tnear()), 32 * g + index, t) &&
             reportHit(g, normal, index, t, sides);
    }
    return reportNearest(g, mask);
  }

private:
  /*! Reports hits in any order, without their data. */
  template<typename Triangles>
  __forceinline bool reportAny(uint32_t g, const Triangles& triangles) {
    for (uint32_t rest = triangles.mask; rest; rest &= rest - 1) {
      const uint32_t index = uint32_t(bsf(rest));
      const VertTriangle triangle = triangleOf(cached, g, index);
      if (!triangle.contains(vertRay, sidesOf(triangles, triangle, vertRay, index))) continue;
      const TriangleSpan<double> span = triangle.span(vertRay);
      float t = 0.0f;
      if (!(likely(double(target.tnear()) <= span.nearest && span.farthest < double(target.tfar()))) &&
          !isInRange(triangle.distance(vertRay, triangle.normal(), target.tnear()), 32 * g + index, t))
        continue;
      SurfaceHit1 hit = {0.0f, 0.0f, t, Vec3fa(zero)};
      if (target.report(block, block->primID, hit)) return true;
    }
    return false;
  }

  /*! report() for several triangles. Computes all distances first: a filter may reject the nearest hit. */
  bool reportNearest(uint32_t g, uint32_t mask) {
    float t[32];
    uint32_t inRange = 0;
    for (uint32_t rest = mask; rest; rest &= rest - 1) {
      const uint32_t index = uint32_t(bsf(rest));
      const VertTriangle triangle = triangleOf(cached, g, index);
      if (triangle.contains(vertRay, triangle.sides(vertRay)) &&
          isInRange(triangle.distance(vertRay, triangle.normal(), target.tnear()), 32 * g + index, t[index]))
        inRange |= 1u << index;
    }
    while (inRange) {
      uint32_t best = uint32_t(bsf(inRange));
      for (uint32_t others = inRange & (inRange - 1); others; others &= others - 1) {
        const uint32_t index = uint32_t(bsf(others));
        if (t[index] < t[best]) best = index;
      }
      inRange &= ~(1u << best);
      const VertTriangle triangle = triangleOf(cached, g, best);
      if (reportHit(g, triangle.normal(), best, t[best], triangle.sides(vertRay))) return true;
    }
    return false;
  }

  /*! True if the hit is between tnear and tfar, or at tfar with precedence over the nearest hit. Sets t to the
   *  distance rounded to float. triangle: NearestVertHit::triangle. */
  __forceinline bool isInRange(double distance, uint32_t triangle, float& t) const {
    t = float(distance);
    const float tfar = target.tfar();
    const uint32_t result = classifyHit(distance, target.tnear(), tfar, nearest.block && nearest.t == tfar);
    return likely(result == hitIsInRange) || (result == hitIsTied && nearest.losesTieTo(block, triangle, target.ids()));
  }

  __forceinline bool reportHit(uint32_t g, const WideNormal<double>& normal, uint32_t index, float t,
                               const VertTriangle::Sides& sides) {
    SurfaceHit1 hit;
    hit.t = t;
    hit.Ng = VertTriangle::Ng(vertRay, normal);
    const SurfacePoint point = pointOfHit(cached, block, g, index, sides);
    hit.u = point.u;
    hit.v = point.v;
    if (!target.report(block, point.primID, hit)) return false;
    nearest = NearestVertHit(block, 32 * g + index, t);
    return true;
  }

  const Target target;
  const VertRay& vertRay;
  NearestVertHit& nearest;
  const VertHeader* block;
  const Cached& cached;
};
} // namespace embree::isa::cbvh
