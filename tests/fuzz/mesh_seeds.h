// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

// Mesh blocks as seeds, static and moving.

#include "fuzz_input.h"
#include "kernels/cvert/decoder/validate_mesh.h"
#include "kernels/cvert/encoder/mesh_motion_encoder.h"
#include "support/mesh_groups.h"

#include <cmath>
#include <memory>
#include <vector>

namespace programs::test {

using namespace cvert;

// Calls write(name, block, bytes) for sheets over the unit square: connected and as soups, on and off lattices, with
// numbers in order and without order, at rest and (if connected) with three time steps.
template<typename Write>
void forEachMeshSeed(const Write& write) {
  const auto still = std::make_unique<MeshEncoder>();
  const auto moving = std::make_unique<MeshMotionEncoder>();
  std::vector<uint32_t> memory(MeshMotionEncoder::maxBytes(3) / 4 + 1);
  uint8_t* const block = (uint8_t*)memory.data();
  for (uint32_t size : {1u, 4u, 11u})
    for (uint32_t form = 0; form < 8; form++) {
      const bool isSoup = form & 1, isOnLattice = form & 2, isOrdered = form & 4;
      std::vector<MeshTriangle> triangles;
      std::vector<uint32_t> ids;
      for (uint32_t t = 0; t < 2 * size * size; t++) {
        const uint32_t corners[2][3][2] = {{{0, 0}, {1, 0}, {0, 1}}, {{1, 1}, {0, 1}, {1, 0}}};
        MeshTriangle triangle;
        triangle.number = isOrdered ? t : (37 * t) % 1000;
        for (int c = 0; c < 3; c++) {
          const uint32_t x = t / 2 % size + corners[t % 2][c][0], y = t / (2 * size) + corners[t % 2][c][1];
          const float scale = isSoup ? 0.9f : 1.0f, u = float(x) * scale / float(size), v = float(y) / float(size);
          const float p[3] = {u + 0.02f * std::sin(5 * v), v,
                              0.1f * std::sin(4 * u + 3 * v) + (isSoup ? 0.01f * float(t % 7) : 0)};
          for (int k = 0; k < 3; k++) triangle.corners[c][k] = isOnLattice ? std::round(p[k] * 4096) / 4096 : p[k];
          ids.push_back(y * (size + 1) + x);
        }
        triangles.push_back(triangle);
      }
      for (uint32_t groupSize : {16u, 32u}) {
        const std::string name = std::to_string(size) + "-" + std::to_string(form) + "-" + std::to_string(groupSize);
        MeshStatistics statistics;
        const auto keep = [&](const std::string& prefix, size_t bytes) {
          REQUIRE(!validateMesh(block, bytes));
          REQUIRE(validateMesh(block, bytes - 4));
          write(prefix + name, block, bytes);
        };
        const MeshGroups groups = fullGroups(uint32_t(triangles.size()), groupSize);
        still->encodeCluster(triangles.data(), groups, false, 0, block, statistics,
                             [&](size_t bytes, uint32_t, uint32_t) { keep("", bytes); });
        if (isSoup) continue; // positions at later steps belong to shared vertices
        MovingCluster cluster;
        cluster.triangles = triangles.data();
        cluster.ids = (const uint32_t(*)[3])ids.data();
        cluster.groups = groups;
        cluster.areHalvesOfQuads = false;
        cluster.surface = 0;
        cluster.begin = 0;
        cluster.end = 1;
        cluster.numSteps = 3;
        const auto locate = [&](uint32_t step, uint32_t id, float out[3]) {
          const float x = float(id % (size + 1)) / float(size), y = float(id / (size + 1)) / float(size),
                      s = float(step);
          const float p[3] = {x + 0.1f * s * y, y - 0.1f * s, 0.1f * std::sin(4 * x + s)};
          for (int k = 0; k < 3; k++) out[k] = isOnLattice ? std::round(p[k] * 4096) / 4096 : p[k];
        };
        moving->encodeCluster(cluster, block, statistics, locate,
                              [&](size_t bytes, uint32_t, uint32_t) { keep("moving-", bytes); });
      }
    }
}

} // namespace programs::test
