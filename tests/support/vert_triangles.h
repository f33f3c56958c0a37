// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The triangles that a scene of cVERT holds, decoded from its blocks by scalar code. */

#include "kernels/cbvh/trace/scalar_vert.h"
#include "support/scene_blocks.h"

#include <array>
#include <map>
#include <memory>

namespace cbvh::test {

struct VertTriangle
{
  std::array<std::array<float, 3>, 3> vertices; // in GRID's order
  unsigned geomID, primID;
  double u[3], v[3];                            // of its vertices, in a patch without lower edges

  bool hasArea() const { return vertices[0] != vertices[1] && vertices[1] != vertices[2] && vertices[2] != vertices[0]; }
};

inline std::vector<VertTriangle> vertTriangles(RTCScene scene)
{
  using namespace embree::cbvh;
  std::vector<VertTriangle> triangles;
  for (const VertHeader* block : sceneVertBlocks(scene)) {
    const auto decoded = std::make_unique<ScalarVertBlock>(block);
    const double quadsX = patchQuadsX(block->rates), quadsY = patchQuadsY(block->rates);
    for (uint32_t y = 0; y < decoded->quadsY; y++)
      for (uint32_t x = 0; x < decoded->quadsX; x++)
        for (int second = 0; second < 2; second++) {
          // (00,10,01) and (01,10,11)
          const uint32_t dx[2][3] = {{0, 1, 0}, {0, 1, 1}}, dy[2][3] = {{0, 0, 1}, {1, 0, 1}};
          VertTriangle t;
          t.geomID = block->geomID;
          t.primID = block->primID;
          for (int c = 0; c < 3; c++) {
            const uint32_t i = x + dx[second][c], j = y + dy[second][c];
            std::copy_n(decoded->vertex(i, j), 3, t.vertices[c].begin());
            for (float& f : t.vertices[c]) f += 0.0f; // -0 is 0
            t.u[c] = 0.5*vertCornerU(block->place) + (vertX(block->place) + i)/quadsX;
            t.v[c] = 0.5*vertCornerV(block->place) + (vertY(block->place) + j)/quadsY;
          }
          triangles.push_back(t);
        }
  }
  return triangles;
}

// Edges that are not as often one way as the other, of triangles that have an area.
inline size_t countOpenEdges(const std::vector<VertTriangle>& triangles)
{
  typedef std::array<float, 3> Vertex;
  std::map<std::pair<Vertex, Vertex>, int> surplus;
  for (const VertTriangle& t : triangles) {
    if (!t.hasArea()) continue;
    for (int i = 0; i < 3; i++) {
      const Vertex &a = t.vertices[i], &b = t.vertices[(i+1) % 3];
      if (a < b) surplus[{a, b}]++; else surplus[{b, a}]--;
    }
  }
  size_t open = 0;
  for (const auto& edge : surplus) open += edge.second != 0;
  return open;
}

} // namespace cbvh::test
