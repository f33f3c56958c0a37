// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Measures how many quads a patch needs, from displaced sample points. Each side has at least one point per four quads,
 * but at most 65. */

#include "dicing_view.h"

namespace embree {
class DicingSamples {
public:
  DicingSamples(SubdivMesh* mesh, const DicingView& view) : mesh(mesh), view(view) {}

  /*! Estimates how many quads each edge of a patch needs. (u0,v0): corner of the patch in parameters of the face; the
   *  patch has size 1 x 1. quads: set, along v = 0, u = 1, v = 1 and u = 0; at least 1, not rounded. */
  void measure(unsigned primID, unsigned step, float u0, float v0, float quads[4]) {
    const unsigned minCells = 2, maxCells = 64; // cells per side
    for (unsigned n = minCells;;) {
      sample(primID, step, u0, v0, n);
      estimateEdges(n, quads);
      const float highest = max(max(quads[0], quads[1]), max(quads[2], quads[3]));
      unsigned next = n;
      while (next < maxCells && float(4 * next) < highest) next *= 2;
      if (next == n) return;
      n = next;
    }
  }

private:
  /*! Sets `points` to (n+1) x (n+1) displaced points of the patch in world space, row by row. */
  void sample(unsigned primID, unsigned step, float u0, float v0, unsigned n) {
    const unsigned count = (n + 1) * (n + 1), padded = (count + 15) & ~15u;
    values.resize(14 * size_t(padded)); // u, v, and the components of P, dPdu, dPdv and N
    faces.assign(padded, primID);
    float* a = values.data();
    float *u = a, *v = a + padded, *P = a + 2 * padded, *dPdu = a + 5 * padded, *dPdv = a + 8 * padded,
          *N = a + 11 * padded;
    for (unsigned i = 0; i < padded; i++) {
      const unsigned k = min(i, count - 1);
      u[i] = u0 + float(k % (n + 1)) / float(n);
      v[i] = v0 + float(k / (n + 1)) / float(n);
    }
    RTCInterpolateNArguments args;
    memset(&args, 0, sizeof(args));
    args.geometry = (RTCGeometry)mesh;
    args.primIDs = faces.data();
    args.u = u;
    args.v = v;
    args.N = padded;
    args.bufferType = RTC_BUFFER_TYPE_VERTEX;
    args.bufferSlot = step;
    args.P = P;
    args.dPdu = dPdu;
    args.dPdv = dPdv;
    args.valueCount = 3;
    mesh->interpolateN(&args);
    if (mesh->displFunc) {
      for (unsigned i = 0; i < padded; i++) {
        const Double3 n = cross(Double3{dPdu[i], dPdu[padded + i], dPdu[2 * padded + i]},
                                Double3{dPdv[i], dPdv[padded + i], dPdv[2 * padded + i]});
        const double length2 = dot(n, n), scale = length2 > 0.0 ? 1.0 / std::sqrt(length2) : 1.0;
        N[i] = float(scale * n.x);
        N[padded + i] = float(scale * n.y);
        N[2 * padded + i] = float(scale * n.z);
      }
      RTCDisplacementFunctionNArguments displacement;
      displacement.geometryUserPtr = mesh->userPtr;
      displacement.geometry = (RTCGeometry)mesh;
      displacement.primID = primID;
      displacement.timeStep = step;
      displacement.u = u;
      displacement.v = v;
      displacement.Ng_x = N;
      displacement.Ng_y = N + padded;
      displacement.Ng_z = N + 2 * padded;
      displacement.P_x = P;
      displacement.P_y = P + padded;
      displacement.P_z = P + 2 * padded;
      displacement.N = count;
      mesh->displFunc(&displacement);
    }
    points.resize(count);
    for (unsigned i = 0; i < count; i++) points[i] = view.toWorld(Double3{P[i], P[padded + i], P[2 * padded + i]});
  }

  /*! Sets each edge's number of quads, from n x n cells of samples, grouped into up to 4 x 4 parts. A part needs the
   *  quadratic mean over its cells: quads are uniform in parameter space, so quads on steep displacement are longer.
   *  As parts can be at different distances, an edge gets the maximum of the adjacent half of the patch. */
  void estimateEdges(unsigned n, float quads[4]) const {
    const unsigned parts = min(n, 4u), cells = n / parts;
    for (int i = 0; i < 4; i++) quads[i] = 1.0f;
    for (unsigned py = 0; py < parts; py++)
      for (unsigned px = 0; px < parts; px++) {
        double sum[2] = {0, 0};
        size_t count = 0;
        for (unsigned y = py * cells; y < (py + 1) * cells; y++)
          for (unsigned x = px * cells; x < (px + 1) * cells; x++) {
            const Double3 corners[4] = {at(n, x, y), at(n, x + 1, y), at(n, x, y + 1), at(n, x + 1, y + 1)};
            const double perUnit = double(n) * view.quadsPerUnit(corners);
            const double u =
                perUnit * perUnit * 0.5 * (squared(corners[0], corners[1]) + squared(corners[2], corners[3]));
            const double v =
                perUnit * perUnit * 0.5 * (squared(corners[0], corners[2]) + squared(corners[1], corners[3]));
            // not finite, or contains the eye; neighboring cells are sufficient
            if (!std::isfinite(u) || !std::isfinite(v)) continue;
            sum[0] += min(u, maxSquared);
            sum[1] += min(v, maxSquared);
            count++;
          }
        if (!count) continue;
        const float u = float(std::sqrt(sum[0] / double(count))), v = float(std::sqrt(sum[1] / double(count)));
        if (2 * py < parts) quads[0] = max(quads[0], u);
        if (2 * py + 2 > parts) quads[2] = max(quads[2], u);
        if (2 * px < parts) quads[3] = max(quads[3], v);
        if (2 * px + 2 > parts) quads[1] = max(quads[1], v);
      }
  }

  static constexpr double maxSquared = 1e38; //!< square roots are far above all rates, and representable as floats

  const Double3& at(unsigned n, unsigned x, unsigned y) const { return points[y * (n + 1) + x]; }
  static double squared(const Double3& a, const Double3& b) {
    const Double3 d = b - a;
    return dot(d, d);
  }

  SubdivMesh* mesh;
  const DicingView& view;
  std::vector<float> values;
  std::vector<unsigned> faces;
  std::vector<Double3> points;
};
} // namespace embree
