// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Moving meshes, and their mesh blocks. */

#include "kernels/cvert/encoder/mesh_motion_encoder.h"
#include "support/mesh_groups.h"
#include "support/random.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

namespace programs::test {

typedef std::array<float, 3> Point;
typedef std::vector<uint32_t> Words; // aligned to 4 bytes, exactly as large as the block

struct MovingMesh {
  std::vector<std::array<uint32_t, 3>> triangles; // IDs of vertices
  std::vector<std::vector<Point>> steps;          // vertices at each step
};

struct EncodedBlock {
  Words words;
  uint32_t first, stored; // first triangle in the mesh, and number of triangles

  const cvert::MeshHeader* block() const { return (const cvert::MeshHeader*)words.data(); }
  size_t size() const { return 4 * words.size(); }
};

// Cluster by cluster. Numbers of triangles are their indices.
inline std::vector<EncodedBlock> encode(cvert::MeshMotionEncoder& encoder, const MovingMesh& mesh,
                                        uint32_t groupTriangles, cvert::MeshStatistics& statistics) {
  using namespace cvert;
  std::vector<EncodedBlock> blocks;
  std::vector<MeshTriangle> triangles;
  for (const auto& ids : mesh.triangles) {
    MeshTriangle t;
    for (int c = 0; c < 3; c++) std::memcpy(t.corners[c], mesh.steps[0][ids[c]].data(), sizeof(t.corners[c]));
    t.number = uint32_t(triangles.size());
    triangles.push_back(t);
  }
  const uint32_t perCluster = std::min(groupTriangles * maxMeshGroups, maxMeshTriangles);
  std::vector<uint8_t> buffer(MeshMotionEncoder::maxBytes(mesh.steps.size()) + 4);
  uint8_t* const block = buffer.data() + (-size_t(buffer.data()) & 3);
  for (uint32_t begin = 0; begin < triangles.size(); begin += perCluster) {
    MovingCluster cluster;
    cluster.triangles = triangles.data() + begin;
    cluster.ids = (const uint32_t(*)[3])mesh.triangles[begin].data();
    cluster.groups = fullGroups(std::min(uint32_t(triangles.size()) - begin, perCluster), groupTriangles);
    cluster.areHalvesOfQuads = false;
    cluster.surface = 3;
    cluster.begin = 0.25f;
    cluster.end = 0.75f;
    cluster.numSteps = uint32_t(mesh.steps.size());
    encoder.encodeCluster(
        cluster, block, statistics,
        [&](uint32_t step, uint32_t id, float out[3]) {
          std::memcpy(out, mesh.steps[step][id].data(), sizeof(float[3]));
        },
        [&](size_t bytes, uint32_t first, uint32_t stored) {
          EXPECT_LE(bytes, MeshMotionEncoder::maxBytes(mesh.steps.size()));
          Words words(bytes / 4);
          std::memcpy(words.data(), block, bytes);
          blocks.push_back({words, begin + first, stored});
        });
  }
  return blocks;
}

typedef std::array<double, 3> Real;
typedef std::function<Real(const Real&, double)> Motion; // position at a time from 0 to 1

inline float stored(double x, int exponent) {
  return exponent <= -1000 ? float(x) : float(std::ldexp(std::floor(std::ldexp(x, -exponent) + 0.5), exponent));
}

// A wavy sheet of triangles with random diagonals. exponent: of its lattice; -1000 for none.
inline MovingMesh sheet(Random& random, uint32_t size, uint32_t numSteps, int exponent, const Motion& motion) {
  MovingMesh mesh;
  std::vector<Real> points;
  for (uint32_t y = 0; y <= size; y++)
    for (uint32_t x = 0; x <= size; x++) {
      const double u = x + random.uniform(-0.3, 0.3), v = y + random.uniform(-0.3, 0.3);
      points.push_back({0.1 * u, 0.1 * v, 0.03 * std::sin(0.4 * u) * std::cos(0.3 * v) + 0.002 * random.normal()});
    }
  for (uint32_t s = 0; s < numSteps; s++) {
    mesh.steps.emplace_back();
    for (const Real& p : points) {
      const Real q = motion(p, double(s) / (numSteps - 1));
      mesh.steps.back().push_back({stored(q[0], exponent), stored(q[1], exponent), stored(q[2], exponent)});
    }
  }
  for (uint32_t y = 0; y < size; y++)
    for (uint32_t x = 0; x < size; x++) {
      const uint32_t a = y * (size + 1) + x, b = a + 1, c = a + size + 1, d = c + 1;
      const bool other = random.chance(0.5);
      std::array<uint32_t, 3> t[2] = {{a, b, other ? d : c}, {other ? a : b, d, c}};
      for (auto& corners : t) {
        std::rotate(corners.begin(), corners.begin() + random.below(3), corners.end());
        mesh.triangles.push_back(corners);
      }
    }
  return mesh;
}

inline Real still(const Real& p, double) { return p; }

inline Real turned(const Real& p, double time) {
  const double a = 0.2 * time, x = p[0] * std::cos(a) - p[1] * std::sin(a), y = p[0] * std::sin(a) + p[1] * std::cos(a);
  return {x + 0.3 * time, y, p[2] - 0.1 * time};
}

inline Real bent(const Real& p, double time) {
  return {p[0] + 0.02 * time * std::sin(3 * p[1]), p[1] * (1 + 0.1 * time), p[2] + 0.1 * time * p[0] * p[0]};
}

// i selects the motion, the distance from the origin, and whether there is a lattice; all else is random.
inline MovingMesh sheetOfSeries(Random& random, int i) {
  const double far = std::vector<double>{0, 10, 1e4, 1e6}[i / 4 % 4];
  const Motion motions[4] = {still, turned, bent, [&](const Real& p, double) {
                               return Real{p[0] + random.normal(), p[1], p[2] + random.normal()};
                             }};
  const Motion moved = [&](const Real& p, double time) {
    Real q = motions[i % 4](p, time);
    for (double& x : q) x += far;
    return q;
  };
  const int exponent = i % 3 == 0 ? -1000 : -int(random.below(16));
  return sheet(random, 1 + random.below(14), 2 + random.below(4), exponent, moved);
}

inline uint32_t anyGroupTriangles(Random& random) { return std::vector<uint32_t>{1, 3, 16, 32}[random.below(4)]; }

} // namespace programs::test
