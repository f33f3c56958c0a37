// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Surfaces diced by an application: grids of vertices, as geometries of type RTC_GEOMETRY_TYPE_GRID. */

#include "support/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <vector>

namespace programs::test {

// Position of a vertex at a time step.
typedef std::function<Vec(const Vec& position, unsigned step)> DicedMotion;
inline std::vector<Vec> movedTo(const std::vector<Vec>& vertices, const DicedMotion& motion, unsigned step) {
  std::vector<Vec> moved = vertices;
  if (motion)
    for (Vec& p : moved) p = motion(p, step);
  return moved;
}

struct Diced {
  std::vector<Vec> vertices;
  DicedMotion motion;
  std::vector<RTCGrid> grids;

  const Vec& vertex(const RTCGrid& grid, unsigned x, unsigned y) const {
    return vertices[grid.startVertexID + y * grid.stride + x];
  }
  Vec& vertex(const RTCGrid& grid, unsigned x, unsigned y) {
    return vertices[grid.startVertexID + y * grid.stride + x];
  }

  size_t quads() const {
    size_t n = 0;
    for (const RTCGrid& grid : grids) n += size_t(grid.width - 1) * size_t(grid.height - 1);
    return n;
  }

  // The grid shares no vertices with other grids.
  void add(unsigned width, unsigned height, const std::function<Vec(unsigned x, unsigned y)>& position) {
    grids.push_back({unsigned(vertices.size()), width, (unsigned short)width, (unsigned short)height});
    for (unsigned y = 0; y < height; y++)
      for (unsigned x = 0; x < width; x++) vertices.push_back(position(x, y));
  }
};

inline float roundTo(double x, double lattice) {
  return float(lattice > 0 ? std::nearbyint(x / lattice) * lattice : x);
}

// A bumpy sheet over [-1,1]^2: n x n grids of `quads` quads that share the vertices of one buffer by index. lattice:
// positions are multiples of it, unless it is 0.
inline Diced dicedSheet(unsigned n, unsigned quads, double lattice = 0) {
  Diced diced;
  const unsigned side = n * quads + 1;
  for (unsigned y = 0; y < side; y++)
    for (unsigned x = 0; x < side; x++) {
      const double u = 2.0 * x / (side - 1) - 1, v = 2.0 * y / (side - 1) - 1;
      diced.vertices.push_back({roundTo(u + 0.02 * std::sin(9 * v), lattice), roundTo(v, lattice),
                                roundTo(0.1 * std::sin(7 * u + 3 * v) * std::cos(5 * v), lattice)});
    }
  for (unsigned y = 0; y < n; y++)
    for (unsigned x = 0; x < n; x++)
      diced.grids.push_back(
          {y * quads * side + x * quads, side, (unsigned short)(quads + 1), (unsigned short)(quads + 1)});
  return diced;
}

// A closed, bumpy ball: n x n grids of `quads` quads on each side of a cube. Grids have the same floats on common
// borders, in vertices of their own. warp: above 1, quads in the middle of a side are smaller, much smaller for 3.
inline Diced dicedBall(unsigned n, unsigned quads, double warp = 1) {
  Diced diced;
  const int side = int(n * quads);
  for (int face = 0; face < 6; face++)
    for (unsigned gy = 0; gy < n; gy++)
      for (unsigned gx = 0; gx < n; gx++)
        diced.add(quads + 1, quads + 1, [&](unsigned x, unsigned y) {
          int cube[3];
          const int axis = face % 3, sign = face < 3 ? 1 : -1;
          cube[axis] = sign * side;
          cube[(axis + 1) % 3] = 2 * int(gx * quads + x) - side;
          cube[(axis + 2) % 3] = sign * (2 * int(gy * quads + y) - side);
          double p[3], length = 0;
          for (int k = 0; k < 3; k++) {
            p[k] = std::tan(std::copysign(std::pow(std::fabs(double(cube[k]) / side), warp), cube[k]) * M_PI / 4);
            length += p[k] * p[k];
          }
          const double r = (1 + 0.05 * std::sin(8 * p[0]) * std::sin(7 * p[1] + 5 * p[2])) / std::sqrt(length);
          return Vec{float(r * p[0]), float(r * p[1]), float(r * p[2])};
        });
  return diced;
}

// maxError: negative for the default; ignored unless a compression or flags are set.
inline void commitAs(RTCGeometry geometry, RTCCompression compression, unsigned flags, float maxError = -1) {
  if (compression != RTC_COMPRESSION_INHERIT || flags) {
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = compression;
    args.flags = flags;
    args.maxError = maxError;
    rtcSetGeometryCompression(geometry, &args);
  }
  rtcCommitGeometry(geometry);
}

// Returns a committed geometry, which the caller releases. steps: the vertices at each time step.
inline RTCGeometry newGridsOf(RTCDevice device, const std::vector<RTCGrid>& grids,
                              const std::vector<std::vector<Vec>>& steps, RTCCompression compression,
                              unsigned flags = 0, float maxError = -1) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
  rtcSetGeometryTimeStepCount(geometry, unsigned(steps.size()));
  for (unsigned t = 0; t < steps.size(); t++)
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, t, RTC_FORMAT_FLOAT3, steps[t]);
  setBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, grids);
  commitAs(geometry, compression, flags, maxError);
  return geometry;
}

inline RTCGeometry newGrids(RTCDevice device, const Diced& diced, RTCCompression compression = RTC_COMPRESSION_INHERIT,
                            unsigned flags = 0, unsigned timeSteps = 1) {
  std::vector<std::vector<Vec>> steps;
  for (unsigned t = 0; t < timeSteps; t++) steps.push_back(movedTo(diced.vertices, diced.motion, t));
  return newGridsOf(device, diced.grids, steps, compression, flags);
}

class GridScene : public Scene {
public:
  GridScene(RTCDevice device, const Diced& diced, RTCCompression compression = RTC_COMPRESSION_CVERT) : Scene(device) {
    attach(*this, newGrids(device, diced, compression));
    rtcCommitScene(*this);
  }
};

// From a random direction through a point inside a random triangle.
inline RTCRayHit rayAt(Random& random, const Diced& diced) {
  const RTCGrid& grid = diced.grids[random.below(unsigned(diced.grids.size()))];
  const unsigned x = random.below(grid.width - 1u), y = random.below(grid.height - 1u);
  double a = random.uniform(0.05, 0.45), b = random.uniform(0.05, 0.45);
  if (random.chance(0.5)) {
    a = 1 - a;
    b = 1 - b;
  }
  const Vec p[4] = {diced.vertex(grid, x, y), diced.vertex(grid, x + 1, y), diced.vertex(grid, x, y + 1),
                    diced.vertex(grid, x + 1, y + 1)};
  Vec target, origin, direction;
  double d[3], length = 0;
  for (double& c : d) {
    c = random.normal();
    length += c * c;
  }
  for (int k = 0; k < 3; k++) {
    target[k] = float(a + b <= 1 ? p[0][k] + a * (p[1][k] - p[0][k]) + b * (p[2][k] - p[0][k])
                                 : p[3][k] + (1 - a) * (p[2][k] - p[3][k]) + (1 - b) * (p[1][k] - p[3][k]));
    origin[k] = float(target[k] + 3 * d[k] / std::sqrt(length));
    direction[k] = target[k] - origin[k];
  }
  return makeRay(origin, direction);
}

} // namespace programs::test
