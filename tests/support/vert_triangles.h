// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The triangles of a scene in cVERT or cTILE, decoded from its blocks by scalar code. */

#include "kernels/cvert/decoder/decoded_block.h"
#include "support/scene_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

namespace programs::test {

struct VertTriangle {
  std::array<std::array<float, 3>, 3> vertices; // in the order of GRID
  unsigned geomID, primID;
  // of its vertices, as if all edges had the highest rate
  double u[3], v[3];

  bool hasArea() const {
    return vertices[0] != vertices[1] && vertices[1] != vertices[2] && vertices[2] != vertices[0];
  }
};

inline std::vector<VertTriangle> vertTriangles(RTCScene scene) {
  using namespace cvert;
  std::vector<VertTriangle> triangles;
  for (const VertHeader* block : sceneVertBlocks(scene)) {
    const auto decoded = std::make_unique<DecodedBlock>(block);
    const double quadsX = patchQuadsX(block->patchQuads), quadsY = patchQuadsY(block->patchQuads);
    const VertEdges edges = edgesOf(block);
    for (uint32_t y = 0; y < decoded->quadsY; y++)
      for (uint32_t x = 0; x < decoded->quadsX; x++)
        for (int second = 0; second < 2; second++) {
          // (00,10,01) and (01,10,11)
          const uint32_t dx[2][3] = {{0, 1, 0}, {0, 1, 1}}, dy[2][3] = {{0, 0, 1}, {1, 0, 1}};
          VertTriangle t;
          t.geomID = geometryOf(scene, block->surface);
          t.primID = block->primID;
          for (int c = 0; c < 3; c++) {
            const uint32_t i = x + dx[second][c], j = y + dy[second][c];
            std::copy_n(decoded->vertex(i, j), 3, t.vertices[c].begin());
            for (float& f : t.vertices[c]) f += 0.0f; // maps -0 to 0
            t.u[c] = 0.5 * vertCornerU(edges) + (vertFirstX(block->region) + i) / quadsX;
            t.v[c] = 0.5 * vertCornerV(edges) + (vertFirstY(block->region) + j) / quadsY;
          }
          triangles.push_back(t);
        }
  }
  return triangles;
}

// Intersection of a ray with one of the triangles.
struct ExactHit {
  const VertTriangle* triangle = nullptr;
  double t = INFINITY, weight[3];
};

// Distance of a point from the nearest edge relative to the triangle; negative if the point is outside.
inline double inside(const ExactHit& h) { return std::min({h.weight[0], h.weight[1], h.weight[2]}); }

// Intersects the ray's line with the triangle's plane in double precision. Returns false if they
// are parallel.
inline bool meet(const RTCRay& r, const VertTriangle& triangle, ExactHit& hit) {
  const double o[3] = {r.org_x, r.org_y, r.org_z}, d[3] = {r.dir_x, r.dir_y, r.dir_z};
  double e1[3], e2[3], p[3], q[3], s[3];
  for (int k = 0; k < 3; k++) {
    e1[k] = double(triangle.vertices[1][k]) - triangle.vertices[0][k];
    e2[k] = double(triangle.vertices[2][k]) - triangle.vertices[0][k];
    s[k] = o[k] - triangle.vertices[0][k];
  }
  const auto cross = [](const double a[3], const double b[3], double out[3]) {
    for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
  };
  const auto dot = [](const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  cross(d, e2, p);
  const double det = dot(e1, p);
  if (det == 0) return false;
  cross(s, e1, q);
  hit.triangle = &triangle;
  hit.weight[1] = dot(s, p) / det;
  hit.weight[2] = dot(d, q) / det;
  hit.weight[0] = 1 - hit.weight[1] - hit.weight[2];
  hit.t = dot(e2, q) / det;
  return true;
}

// Number of edges of non-degenerate triangles that do not occur equally often in both directions.
inline size_t countOpenEdges(const std::vector<VertTriangle>& triangles) {
  typedef std::array<float, 3> Vertex;
  std::map<std::pair<Vertex, Vertex>, int> surplus;
  for (const VertTriangle& t : triangles) {
    if (!t.hasArea()) continue;
    for (int i = 0; i < 3; i++) {
      const Vertex &a = t.vertices[i], &b = t.vertices[(i + 1) % 3];
      if (a < b) surplus[{a, b}]++;
      else surplus[{b, a}]--;
    }
  }
  size_t open = 0;
  for (const auto& edge : surplus) open += edge.second != 0;
  return open;
}

} // namespace programs::test
