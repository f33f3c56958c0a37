// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes a cLEAF group: as a lattice, or as separate leaves if no lattice is accurate enough. */

#include "lattice_encoder.h"
#include "separate_encoder.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Returns the width of lips that the group needs, see borderWidthOf(). parent: as in encodeGroup(). */
inline double requiredBorderWidth(const QuadGroup& group, const EncodedGroup& encoded, const NodeBox& parent) {
  double width = 0;
  for (int quad = 0; quad < 4; quad++) {
    if (group.boxes[quad].empty()) continue;
    const NodeBox box = decodeLeaf(encoded.word, encoded.heights, quad, parent).box;
    for (int axis = 0; axis < 2; axis++) {
      const int upper = childCoordinate(quad, axis);
      if (!group.border[axis][upper]) continue;
      for (int c = 0; c < 4; c++) {
        if (childCoordinate(c, axis) != upper) continue;
        const double u = (group.vertexOf(quad, c)[axis] - box.lower[axis]) / box.extent[axis];
        // 1e-3: margin for the rounding of a ray's u or v
        width = std::max(width, (upper ? 1 - u : u) + group.rounding[axis] / box.extent[axis] + 1e-3);
      }
    }
  }
  return width;
}

/*! parent: decoded box of the group. */
inline EncodedGroup encodeGroup(const NodeBox& parent, const QuadGroup& group) {
  EncodedGroup out;
  if (!encodeLattice(parent, group, out)) out = encodeSeparate(parent, group);
  out.borderWidth = requiredBorderWidth(group, out, parent);
  return out;
}
}} // namespace embree::cbvh::CBVH_ISA
