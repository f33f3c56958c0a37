// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The map from world space to a block's box [0,1]^3 and its inverse, as linear forms in double precision. local_ray.h
 * maps rays. */

#include "block.h"
#include "../base/codec_names.h"
#include "../../cvert/portable/double4.h"
#include "../../cvert/portable/world.h"

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! The linear form n.p + d. */
struct LinearForm {
  Double3 n;
  double d;
  double operator()(const Double3& p) const { return dot(n, p) + d; }
  friend LinearForm operator+(const LinearForm& a, const LinearForm& b) { return {a.n + b.n, a.d + b.d}; }
  friend LinearForm operator*(double s, const LinearForm& a) { return {s * a.n, s * a.d}; }
};

/*! A map to homogeneous coordinates: x = X/W, y = Y/W, z = Z/W. projective: false only if W is constant. */
struct FrameMap {
  LinearForm X, Y, Z, W;
  bool projective;
};

/*! Maps a point relative to the center to lanes X, Y, Z and W. */
struct FrameLanes {
  Double4 columns[3];

  explicit FrameLanes(const float c[3][4]) : columns{Float4::load(c[0]), Float4::load(c[1]), Float4::load(c[2])} {}

  Double4 operator()(const Double3& d) const {
    return Double4(0.5, 0.5, 0.5, 1.0) + columns[0] * d.x + columns[1] * d.y + columns[2] * d.z;
  }
};

/*! See BlockHeader. */
struct Frame {
  float center[3];
  float columns[3][4];
  bool projective;
  bool degenerate; //!< see fillBox()

  /*! Maps a world position to the frame. */
  void transform(const float p[3], double local[3]) const {
    double l[4];
    transform(FrameLanes(columns), p).store(l);
    for (int k = 0; k < 3; k++) local[k] = l[k];
  }

  /*! As above, with x, y and z in lanes 0 to 2. */
  Double4 transform(const FrameLanes& lanes, const float p[3]) const {
    const Double4 h =
        lanes({double(p[0]) - double(center[0]), double(p[1]) - double(center[1]), double(p[2]) - double(center[2])});
    return h / broadcast<3>(h);
  }
};

/*! Solves X = x W, Y = y W, Z = z W for p, relative to the origin of m. Returns false if no unique, finite p
 *  exists. */
inline bool unproject(const FrameMap& m, double x, double y, double z, Double3& p) {
  const LinearForm a = m.X + (-x) * m.W, b = m.Y + (-y) * m.W, c = m.Z + (-z) * m.W;
  const Double3 bc = cross(b.n, c.n), ca = cross(c.n, a.n), ab = cross(a.n, b.n);
  const double det = dot(a.n, bc);
  if (!(std::fabs(det) > 0)) return false;
  p = (-a.d / det) * bc + (-b.d / det) * ca + (-c.d / det) * ab;
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/*! The map from world points relative to the block's center. */
inline FrameMap frameMap(const float columns[3][4]) {
  auto row = [&](int k, double d) { return LinearForm{{columns[0][k], columns[1][k], columns[2][k]}, d}; };
  return {row(0, 0.5), row(1, 0.5), row(2, 0.5), row(3, 1), true};
}
inline FrameMap frameMap(const Block* block) { return frameMap(block->columns); }

/*! The inverse map. It is projective: 1/W and p/W, for a world point p relative to the center, are linear forms of
 *  the position in the frame. */
struct InverseFrame {
  LinearForm numerator[3], rcpW;

  InverseFrame() : rcpW{{0, 0, 0}, 1} {}

  explicit InverseFrame(const FrameMap& map) {
    double sample[4][4]; // at the origin and one step along each axis
    for (int i = 0; i < 4; i++) {
      Double3 p;
      if (!unproject(map, i == 1, i == 2, i == 3, p)) p = {0, 0, 0};
      const double r = 1 / map.W(p);
      sample[i][0] = p.x * r;
      sample[i][1] = p.y * r;
      sample[i][2] = p.z * r;
      sample[i][3] = r;
    }
    auto form = [&](int k) {
      return LinearForm{{sample[1][k] - sample[0][k], sample[2][k] - sample[0][k], sample[3][k] - sample[0][k]},
                        sample[0][k]};
    };
    for (int k = 0; k < 3; k++) numerator[k] = form(k);
    rcpW = form(3);
  }

  /*! Returns a world position relative to the center. */
  Double3 operator()(const Double3& local) const {
    const double w = 1 / rcpW(local);
    return {w * numerator[0](local), w * numerator[1](local), w * numerator[2](local)};
  }
};
}} // namespace embree::cbvh::CBVH_ISA
