// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Statistics of one or more blocks with frames, which BlockEncoder and its encoders of leaves collect. cGRID has only
 * invalidQuads and affine. */

#include "leaf/leaf_fit.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
struct BlockStatistics {
  uint32_t invalidQuads = 0; //!< quads with a vertex that is not finite
  uint32_t solidLeaves = 0;  //!< cLEAF: leaves whose box is the surface
  bool affine = false;       //!< of the last block's frame
  /*! Largest thickness of a leaf so far, in world space. Encoders need not measure leaves that are thinner. A
   *  caller may therefore begin with the largest thickness that it knows. */
  float maxThickness = 0;
  LeafFit leafFit;

  /*! Adds a leaf to maxThickness. Returns its thickness in world space: the distance, at the middle of the box,
   *  between the plane z = slope[0] x + slope[1] y + const through the middle and the plane that is `thickness`
   *  higher in z. There, a world-space distance d along the plane's normal n (normal.h) raises z above the plane
   *  by d |n|/W (W: see FrameMap). */
  float addThickness(const BlockGeometry& geometry, const NodeBox& box, const double slope[2], double thickness) {
    const double c[3] = {box.lower[0] + 0.5 * box.extent[0], box.lower[1] + 0.5 * box.extent[1],
                         box.lower[2] + 0.5 * box.extent[2]};
    const double k = c[2] - slope[0] * c[0] - slope[1] * c[1];
    double n2 = 0;
    for (int i = 0; i < 3; i++) {
      const float* col = geometry.frame.columns[i];
      const double n = -slope[0] * col[0] - slope[1] * col[1] + col[2] - k * col[3];
      n2 += n * n;
    }
    const float t = float(thickness / (geometry.inverse.rcpW({c[0], c[1], c[2]}) * std::sqrt(n2)));
    if (t > maxThickness) maxThickness = t;
    return t;
  }

  /*! Adds a leaf of cVOXEL, whose box is its surface, to maxThickness. */
  void addBoxThickness(const BlockGeometry& geometry, const NodeBox& box) {
    const double flat[2] = {0, 0};
    addThickness(geometry, box, flat, box.extent[2]);
  }
};
}} // namespace embree::cbvh::CBVH_ISA
