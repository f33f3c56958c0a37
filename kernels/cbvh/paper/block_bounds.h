// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* World-space bounds of an encoded block: of its vertices, and of everything that a ray can hit, which are slightly
 * larger.
 *
 * The top-level BVH uses the bounds of vertices. This loses no hit: a ray through the surface intersects the bounds of
 * the block whose quad it crosses, and that block suffices for a hit (leaf/hit_rule.h). With bounds of leaves, cLEAF
 * would have up to twice as many false hits at silhouettes, and cVOXEL a tenth more.
 *
 * The scene's bounds must contain everything that a ray can hit, because applications clip rays to them. */

#include "../base/codec_names.h"
#include "../../cvert/portable/world.h"
#include "tree.h"
#include "block_geometry.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! World-space bounds of a box in the frame: of its corners, because a projective map keeps the box convex. */
inline WorldBounds boundBox(const NodeBox& box, const float center[3], const InverseFrame& inverse) {
  /* Lanes: corners in x and y. Elements of arrays: lower and upper z. */
  const double x[2] = {box.lower[0], upperOf(box, 0)}, y[2] = {box.lower[1], upperOf(box, 1)};
  const Double4 columns(x[0], x[1], x[0], x[1]), rows(y[0], y[0], y[1], y[1]);
  const double sides[2] = {box.lower[2], upperOf(box, 2)};
  Double4 rcp[2];
  auto form = [&](const LinearForm& f, Double4 out[2]) {
    const Double4 xy = f.n.x * columns + f.n.y * rows;
    for (int i = 0; i < 2; i++) out[i] = xy + f.n.z * sides[i] + f.d;
  };
  form(inverse.rcpW, rcp);
  const Double4 w[2] = {Double4(1.0) / rcp[0], Double4(1.0) / rcp[1]};
  WorldBounds bounds;
  for (int k = 0; k < 3; k++) {
    Double4 n[2];
    form(inverse.numerator[k], n);
    const Double4 p[2] = {double(center[k]) + w[0] * n[0], double(center[k]) + w[1] * n[1]};
    bounds.lower[k] = reduceMin(min(p[0], p[1]));
    bounds.upper[k] = reduceMax(max(p[0], p[1]));
  }
  return bounds;
}

/*! Bounds of the vertices, enlarged by vertexRounding. */
inline WorldBounds boundSurface(const BlockGeometry& geometry) {
  WorldBounds bounds;
  bounds.extend(geometry.lower[0], geometry.lower[1], geometry.lower[2]);
  bounds.extend(geometry.upper[0], geometry.upper[1], geometry.upper[2]);
  const double rounding = vertexRounding * geometry.maxAbsCoordinate;
  for (int k = 0; k < 3; k++) {
    bounds.lower[k] -= rounding;
    bounds.upper[k] += rounding;
  }
  return bounds;
}

/*! Extends `bounds` by everything that a ray can hit. */
class HitBounds {
public:
  HitBounds(WorldBounds& bounds, const Block* block, const BlockGeometry& geometry)
    : bounds(bounds),
      block(block),
      geometry(geometry),
      nodeLevels(block->layout().nodeLevels) {}

  void extend() {
    bounds.extend(boundSurface(geometry));
    /* the triangles of cGRID are within the bounds of their vertices */
    if (block->kind() != Kind::CGRID) extend(0, 0, rootBox());
  }

private:
  /*! Extends the bounds by the leaves below node m, whose box is `box`. */
  void extend(uint32_t level, uint32_t m, const NodeBox& box) {
    const WorldBounds own = boundBox(box, block->center, geometry.inverse);
    if (bounds.contains(own)) return;
    if (level == nodeLevels) {
      bounds.extend(own);
      return;
    }
    for (uint32_t c = 0; c < 4; c++) {
      if (level + 1 == nodeLevels && geometry.boxOf(level + 1, 4 * m + c).empty()) continue;
      extend(level + 1, 4 * m + c, childBox(block, level, m, c, box));
    }
  }

  WorldBounds& bounds;
  const Block* block;
  const BlockGeometry& geometry;
  uint32_t nodeLevels;
};
}} // namespace embree::cbvh::CBVH_ISA
