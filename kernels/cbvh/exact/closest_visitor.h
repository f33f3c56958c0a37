// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Visitor of PointSearch that finds the closest point. The result does not depend on the order of triangles, nor on the
 * instruction set: equally close points are ordered by their triangles. */

#include "../base/closest_point_query.h"
#include "../base/closest_point_result.h"
#include "point_search.h"

namespace embree::isa::cbvh {
class ClosestVisitor {
public:
  static const bool visitsQuads = false;

  __forceinline ClosestVisitor(PointQuery* query, ClosestPointQuery& closest)
    : query(query),
      closest(closest),
      p{query->p.x, query->p.y, query->p.z} {}

  __forceinline double squaredRadius() const { return closest.squaredRadius; }
  __forceinline float radius() const { return float(std::sqrt(closest.squaredRadius)) * (1.0f + 2.0f * floatUlp); }
  __forceinline bool isDone() const { return false; }

  template<typename TriangleAt, typename PointAt>
  __forceinline bool visit(BlockPrimitives, const VertHeader* block, TrianglePlace place, const TriangleAt& triangleAt,
                           const PointAt& pointAt) {
    const WideTriangle<double> triangle = triangleAt(place).wide();
    const PointOfTriangle point = closestPointOfTriangle(p, triangle.at);
    if (!(point.squared <= closest.squaredRadius) || !isPreferred(point.squared, block, place)) return false;
    const VertTriangle::Sides sides = {float(1 - point.w1 - point.w2), float(point.w1), float(point.w2), 1.0f};
    accept(point, triangle, pointAt(sides), block, place);
    return true;
  }

private:
  TriangleKey keyOf(const VertHeader* block, TrianglePlace place) const {
    return TriangleKey{geomIDOf(block), block->primID, block->region, 32 * place.group + place.index};
  }
  uint32_t geomIDOf(const VertHeader* block) const { return closest.scene->surfaceIDs[block->surface]; }

  /*! False if another triangle with precedence is equally close. */
  __forceinline bool isPreferred(double squared, const VertHeader* block, TrianglePlace place) const {
    return closest.function || !closest.isFound || squared < closest.squaredRadius ||
           hasPrecedence(keyOf(block, place), closest.key);
  }

  __noinline void accept(const PointOfTriangle& at, const WideTriangle<double>& triangle, const SurfacePoint& surface,
                         const VertHeader* block, TrianglePlace place) {
    PointOnSurface point;
    setPoint(at, triangle, point);
    point.u = surface.u;
    point.v = surface.v;
    point.primID = surface.primID;
    point.geomID = geomIDOf(block);
    double squaredRadius = at.squared;
    if (closest.function) {
      const float before = float(std::sqrt(closest.squaredRadius));
      float radius = before;
      const bool isAccepted = closest.function(closest.functionPtr, point, radius);
      squaredRadius = isAccepted ? at.squared : closest.squaredRadius;
      if (radius < before) squaredRadius = min(squaredRadius, double(radius) * radius);
      if (isAccepted) setClosest(point, block, place);
    } else setClosest(point, block, place);
    closest.squaredRadius = squaredRadius;
    query->radius = radius();
  }

  void setClosest(const PointOnSurface& point, const VertHeader* block, TrianglePlace place) {
    closest.isFound = true;
    closest.closest = point;
    closest.key = keyOf(block, place);
  }

  PointQuery* const query;
  ClosestPointQuery& closest;
  const double p[3];
};
} // namespace embree::isa::cbvh
