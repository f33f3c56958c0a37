// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* leaf_fit.h for the leaves of four lattices at a time. Most leaves are good, and thinner than the thickest leaf so
 * far: this is tested without divisions and roots. LeafFit and BlockStatistics measure the other leaves. */

#include "lattice_lanes.h"
#include "../block_statistics.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
class LeafLanes {
public:
  /*! m: Morton index of the first group. parents: decoded boxes. All arguments must outlive the object. */
  LeafLanes(const BlockGeometry& geometry, uint32_t m, const NodeBoxes& parents, const GroupLanes& groups,
            const LatticeLanes& lattices)
    : geometry(geometry),
      parents(parents),
      groups(groups),
      lattices(lattices) {
    const uint32_t w = geometry.width;
    const float(*const first)[3] = geometry.vertices + 2 * mortonY(m) * w + 2 * mortonX(m);
    for (uint32_t v = 0; v < 9; v++) {
      const float(*const p)[3] = first + v / 3 * w + v % 3;
      for (int k = 0; k < 3; k++) world[v][k] = Float4(p[0][k], p[2][k], p[2 * w][k], p[2 * w + 2][k]);
    }
  }

  /*! Mask of lanes whose leaf c certainly does not count as poor (LeafFit), and is thinner than maxThickness in
   *  world space. Bits of lanes without a lattice are undefined. */
  uint32_t goodLeaves(int c, float maxThickness) const {
    const int column = childCoordinate(c, 0), row = childCoordinate(c, 1), v = column + 3 * row;
    const Double4 z[4] = {lattices.height(v), lattices.height(v + 1), lattices.height(v + 3), lattices.height(v + 4)};
    const Double4 thickness = lattices.thickness(), half = 0.5 * thickness;
    const Double4 lowest = min(min(z[0], z[1]), min(z[2], z[3])), highest = max(max(z[0], z[1]), max(z[2], z[3]));
    const Float4 bottom = Float4::load(parents.lower[2]), top = bottom + Float4::load(parents.extent[2]);
    const Double4 x[3] = {0.5 * (lattices.plane(0, column) + lattices.plane(0, column + 1)),
                          0.5 * (lattices.plane(1, row) + lattices.plane(1, row + 1)),
                          0.5 * (max(lowest - half, bottom) + min(highest + half, top))};
    const Double4 slope[2] = {0.5 * (z[1] + z[3] - z[0] - z[2]) * lattices.reciprocalWidth(0, column),
                              0.5 * (z[2] + z[3] - z[0] - z[1]) * lattices.reciprocalWidth(1, row)};

    const Double4 k = x[2] - slope[0] * x[0] - slope[1] * x[1];
    Double4 leaf[3], quad[3], a[3], b[3];
    for (int i = 0; i < 3; i++) {
      const float* col = geometry.frame.columns[i];
      leaf[i] = Double4(col[2]) - slope[0] * col[0] - slope[1] * col[1] - k * col[3];
      a[i] = world[v + 4][i] - world[v][i];
      b[i] = world[v + 3][i] - world[v + 1][i];
    }
    for (int i = 0; i < 3; i++) quad[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
    auto dot = [](const Double4 p[3], const Double4 q[3]) { return p[0] * q[0] + p[1] * q[1] + p[2] * q[2]; };
    const Double4 leaf2 = dot(leaf, leaf), quad2 = dot(quad, quad), cosine = dot(leaf, quad);
    const LinearForm& w = geometry.inverse.rcpW;
    const Double4 rcpW = x[0] * w.n.x + x[1] * w.n.y + x[2] * w.n.z + w.d;

    const double margin = 1 - 1e-6;
    // the squared world-space thickness is thickness2/unit2
    const Double4 thickness2 = thickness * thickness, unit2 = margin * rcpW * rcpW * leaf2;
    const double limit2 = 0.5 * maxRelativeThickness * maxRelativeThickness; // if QuadNormal::length is 1
    return ((Double4(0.0) < cosine) &
            (Double4(minNormalCosine * minNormalCosine) * leaf2 * quad2 < margin * cosine * cosine) &
            (thickness2 * thickness2 < limit2 * limit2 * quad2 * unit2 * unit2) &
            (thickness2 < double(maxThickness) * maxThickness * unit2))
        .bits();
  }

  /*! As requiredBorderWidth() of group_encoder.h, over a mask of lanes. */
  double requiredBorderWidth(uint32_t lanes) const {
    double width = 0;
    for (int axis = 0; axis < 2; axis++)
      for (int upper = 0; upper < 2; upper++) {
        const uint32_t border = groups.border[axis][upper] & lanes;
        if (!border) continue;
        const GroupLine side(axis, 2 * upper);
        const Double4 p[3] = {groups.vertices[side.vertex[0]][axis], groups.vertices[side.vertex[1]][axis],
                              groups.vertices[side.vertex[2]][axis]};
        const Double4 lower = lattices.plane(axis, upper),
                      extent = nonZero(Double4(toFloat(lattices.plane(axis, upper + 1)) - toFloat(lower)));
        const Double4 u = ((upper ? min(min(p[0], p[1]), p[2]) : max(max(p[0], p[1]), p[2])) - lower) / extent;
        double widths[4];
        ((upper ? Double4(1.0) - u : u) + groups.rounding[axis] / extent + 1e-3).store(widths);
        for (int lane = 0; lane < 4; lane++)
          if (border >> lane & 1) width = std::max(width, widths[lane]);
      }
    return width;
  }

private:
  const BlockGeometry& geometry;
  const NodeBoxes& parents;
  const GroupLanes& groups;
  const LatticeLanes& lattices;
  Double4 world[9][3];
};
}} // namespace embree::cbvh::CBVH_ISA
