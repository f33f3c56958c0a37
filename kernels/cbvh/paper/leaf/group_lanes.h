// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Four QuadGroups, the children of a node, one per lane. */

#include "../block_geometry.h"
#include "quad_group.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
struct GroupLanes {
  Double4 vertices[9][3];
  Double4 lower[2], upper[2]; //!< bounds of each group's quads in x and y, see QuadGroup::boxes
  double rounding[3];         //!< see QuadGroup
  uint32_t border[2][2];      //!< [axis][upper]: mask of the lanes on the block's border

  GroupLanes() {}

  /*! m: Morton index of the first group. All vertices of the four groups must be finite. */
  GroupLanes(const BlockGeometry& geometry, uint32_t m) {
    const uint32_t side = (1u << geometry.cellLevels) + 1, x = 2 * mortonX(m), y = 2 * mortonY(m);
    const double(*const first)[4] = geometry.local + y * side + x;
    for (uint32_t v = 0; v < 9; v++) {
      const double(*const p)[4] = first + v / 3 * side + v % 3;
      for (int k = 0; k < 3; k++) vertices[v][k] = Double4(p[0][k], p[2][k], p[2 * side][k], p[2 * side + 2][k]);
    }
    const ExactBox* const boxes = &geometry.boxOf(geometry.cellLevels - 1, m);
    for (int k = 0; k < 2; k++) {
      lower[k] = Double4(boxes[0].lower[k], boxes[1].lower[k], boxes[2].lower[k], boxes[3].lower[k]);
      upper[k] = Double4(boxes[0].upper[k], boxes[1].upper[k], boxes[2].upper[k], boxes[3].upper[k]);
    }
    memcpy(rounding, geometry.rounding, sizeof(rounding));
    border[0][0] = x == 0 ? 5 : 0;
    border[1][0] = y == 0 ? 3 : 0;
    border[0][1] = x + 4 == side - 1 ? 10 : 0;
    border[1][1] = y + 4 == side - 1 ? 12 : 0;
  }
};
}} // namespace embree::cbvh::CBVH_ISA
