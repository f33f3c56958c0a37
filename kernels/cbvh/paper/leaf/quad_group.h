// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Input and output of the encoders of cLEAF groups. */

#include "format.h"
#include "../node_encoder.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! 2 x 2 quads in their block's frame, or the quarters of a block's only quad. */
struct QuadGroup {
  double vertices[9][3]; //!< row by row
  ExactBox boxes[4];     //!< bounds of the quads, see BlockGeometry::boundCell(); empty if a vertex is not finite
  double rounding[3];    //!< see BlockGeometry
  bool border[2][2];     //!< [axis][upper]: the side is on the block's border

  /*! True if a corner of a quad is on the block's border. */
  bool isOnBorder(int quad, int corner) const {
    for (int axis = 0; axis < 2; axis++) {
      const int upper = childCoordinate(corner, axis);
      if (childCoordinate(quad, axis) == upper && border[axis][upper]) return true;
    }
    return false;
  }

  /*! Rounding error of a vertex's distance in z from a surface with these absolute slopes along x and y. Bounds of
   *  the surface must keep this distance from the vertices. On the block's border, the surface itself must be this
   *  far above them. */
  double slack(const double slope[2]) const {
    return containmentSlack + rounding[2] + slope[0] * rounding[0] + slope[1] * rounding[1];
  }

  /*! Corner (column + 2 row) of a quad (column + 2 row). */
  const double* vertexOf(int quad, int corner) const {
    return vertices[(quad & 1) + (corner & 1) + 3 * ((quad >> 1) + (corner >> 1))];
  }
};

/*! A group in the format of format.h. */
struct EncodedGroup {
  uint32_t word;
  Heights heights;
  double borderWidth; //!< required, see borderWidthOf(); 0 away from the border
};
}} // namespace embree::cbvh::CBVH_ISA
