// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes groups of separate leaves (format.h): one plane per leaf, for quads that no lattice represents. */

#include "quad_group.h"
#include <algorithm>
#include <cmath>

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Fits a plane to the vertices of a quad, by least squares. Sets z to its heights at corners (0,0), (1,0) and
 *  (0,1) of the box. */
inline void fitLeafPlane(const NodeBox& box, const QuadGroup& group, int quad, double z[3]) {
  /* (u,v): positions in the box. m: means. s: sums of products of differences from the means; sums of squares begin
   * at 1e-9, so that slopes are 0 in directions without extent. */
  double u[4], v[4], mu = 0, mv = 0, mz = 0, suu = 1e-9, suv = 0, svv = 1e-9, suz = 0, svz = 0;
  for (int c = 0; c < 4; c++) {
    const double* p = group.vertexOf(quad, c);
    u[c] = (p[0] - box.lower[0]) / box.extent[0];
    v[c] = (p[1] - box.lower[1]) / box.extent[1];
    mu += 0.25 * u[c];
    mv += 0.25 * v[c];
    mz += 0.25 * p[2];
  }
  for (int c = 0; c < 4; c++) {
    const double du = u[c] - mu, dv = v[c] - mv, dz = group.vertexOf(quad, c)[2] - mz;
    suu += du * du;
    suv += du * dv;
    svv += dv * dv;
    suz += du * dz;
    svz += dv * dz;
  }
  const double det = suu * svv - suv * suv;
  const double slopeU = det > 0 ? (suz * svv - svz * suv) / det : 0;
  const double slopeV = det > 0 ? (svz * suu - suz * suv) / det : 0;
  z[0] = mz - slopeU * mu - slopeV * mv;
  z[1] = z[0] + slopeU;
  z[2] = z[0] + slopeV;
}

/*! Returns the 15 bits of a leaf: emptyLeaf for a quad with a vertex that is not finite. box: decoded box of the
 *  leaf. Sets thicknessCode to the smallest code of a thickness that contains the quad's vertices, and therefore
 *  its edges. If there is none, or if the heights cannot represent the plane, returns solidLeaf. Sets thicknessCode
 *  to 0 for empty and solid leaves. */
inline uint32_t encodeSeparateLeaf(const NodeBox& box, const QuadGroup& group, int quad, uint32_t& thicknessCode) {
  thicknessCode = 0;
  if (group.boxes[quad].empty()) return emptyLeaf;
  const HeightBins bins = heightBins(box, separateRange, separateBins);
  double z[3];
  fitLeafPlane(box, group, quad, z);
  uint32_t leaf = 0;
  for (int c = 0; c < 3; c++) {
    const double q = std::floor((z[c] - bins.lower) / bins.size);
    const uint32_t height = !(q > 0) ? 0 : q < separateBins - 1 ? uint32_t(q) : separateBins - 1;
    leaf |= height << (5 * c);
    z[c] = zOfHeight(bins, float(height));
  }
  const double slopes[2] = {std::fabs(z[1] - z[0]) / box.extent[0], std::fabs(z[2] - z[0]) / box.extent[1]},
               slack = group.slack(slopes);
  /* Deviation d: height of the plane above a vertex. lowest, highest: range of d and 0. lowestOnBorder: of the
   * vertices on the block's border. */
  double lowest = 0, highest = 0, lowestOnBorder = 1e300;
  for (int c = 0; c < 4; c++) {
    const double* p = group.vertexOf(quad, c);
    const double u = (p[0] - box.lower[0]) / box.extent[0], v = (p[1] - box.lower[1]) / box.extent[1];
    const double d = z[0] + u * (z[1] - z[0]) + v * (z[2] - z[0]) - p[2];
    lowest = std::min(lowest, d);
    highest = std::max(highest, d);
    if (group.isOnBorder(quad, c)) lowestOnBorder = std::min(lowestOnBorder, d);
  }
  /* on the border, the surface must not be below the edge: raise the plane, in whole bins */
  if (lowestOnBorder < slack) {
    const double raise = std::ceil((slack - lowestOnBorder) / bins.size);
    if (!(raise < separateBins)) return solidLeaf;
    for (int c = 0; c < 3; c++) {
      if (separateHeight(leaf, c) + int(raise) >= separateBins) return solidLeaf;
      leaf += uint32_t(raise) << (5 * c);
    }
    lowest += raise * bins.size;
    highest += raise * bins.size;
  }
  if (leaf == solidLeaf || leaf == emptyLeaf) return solidLeaf; // the bits of these heights are reserved
  const double needed = std::max(-lowest, highest) + slack;     // half of the thickness
  while (thicknessCode < 8 && !(0.5 * separateThickness(thicknessCode) * bins.size >= needed)) thicknessCode++;
  if (thicknessCode < 8) return leaf;
  thicknessCode = 0;
  return solidLeaf;
}

/*! Returns a group of separate leaves, which share the largest of their thickness codes. parent: decoded box of the
 *  group. Does not set borderWidth. */
inline EncodedGroup encodeSeparate(const NodeBox& parent, const QuadGroup& group) {
  EncodedGroup out;
  out.word = encodeNode(parent, group.boxes);
  uint64_t heights = uint64_t(1) << 63;
  uint32_t largestCode = 0;
  for (int c = 0; c < 4; c++) {
    uint32_t code;
    heights |= uint64_t(encodeSeparateLeaf(decodeChild(out.word, c, parent), group, c, code)) << (separateLeafBits * c);
    largestCode = std::max(largestCode, code);
  }
  heights |= uint64_t(largestCode) << separateThicknessShift;
  out.heights = {uint32_t(heights), uint32_t(heights >> 32)};
  return out;
}
}} // namespace embree::cbvh::CBVH_ISA
