// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Meshes without grids. */

#include "support/diced_mesh.h"

namespace programs::test {

// Quads split along random diagonals; triangles begin at random corners.
inline DicedMesh irregularTriangles(const DicedMesh& mesh, Random& random, bool shuffled = true) {
  DicedMesh out;
  out.vertices = mesh.vertices;
  out.motion = mesh.motion;
  for (const auto& q : mesh.quads) {
    const unsigned d = random.below(2);
    for (unsigned half : {0u, 2u}) {
      const unsigned corners[] = {q[(d + half) % 4], q[(d + half + 1) % 4], q[(d + half + 2) % 4]};
      const unsigned turn = random.below(3);
      out.triangles.push_back({corners[turn], corners[(turn + 1) % 3], corners[(turn + 2) % 3]});
    }
  }
  for (size_t i = shuffled ? out.triangles.size() : 0; i-- > 1;)
    std::swap(out.triangles[i], out.triangles[random.below(unsigned(i + 1))]);
  return out;
}

// The quads in random order, beginning at random corners.
inline DicedMesh irregularQuads(const DicedMesh& mesh, Random& random) {
  DicedMesh out = mesh;
  for (auto& q : out.quads) std::rotate(q.begin(), q.begin() + random.below(4), q.end());
  for (size_t i = out.quads.size(); i-- > 1;) std::swap(out.quads[i], out.quads[random.below(unsigned(i + 1))]);
  return out;
}

// The quads, optionally as triangles, with irregular stripes along an axis.
inline DicedMesh partlyIrregular(const DicedMesh& mesh, Random& random, bool asTriangles) {
  DicedMesh regular = mesh, others = mesh, out;
  regular.quads.clear();
  others.quads.clear();
  for (const auto& q : mesh.quads)
    (std::fmod(std::fabs(mesh.vertices[q[0]][1]), 0.6f) < 0.4f ? regular : others).quads.push_back(q);
  if (!asTriangles) {
    out = regular;
    others = irregularQuads(others, random);
    out.quads.insert(out.quads.end(), others.quads.begin(), others.quads.end());
    return out;
  }
  out = trianglesOf(regular);
  others = irregularTriangles(others, random);
  out.triangles.insert(out.triangles.end(), others.triangles.begin(), others.triangles.end());
  return out;
}

inline DicedMesh jittered(DicedMesh mesh, Random& random, double size, double lattice = 0) {
  for (Vec& p : mesh.vertices)
    for (float& x : p) x = roundTo(x + size * random.uniform(-1, 1), lattice);
  return mesh;
}

struct NamedMesh {
  std::string name;
  DicedMesh mesh;
};

// Meshes of all kinds that mesh blocks store, exactly if vertices are on a lattice.
inline std::vector<NamedMesh> irregularMeshes(Random& random, double lattice) {
  const DicedMesh sheet = jittered(meshOf(dicedSheet(1, 50, lattice), QuadOrder::Rows, random), random, 0.01, lattice),
                  ball = jittered(meshOf(dicedBall(2, 12), QuadOrder::Rows, random), random, 0.01, lattice);
  DicedMesh heap;
  for (unsigned i = 0; i < 2000; i++) {
    const Vec at = {float(random.uniform(-1, 1)), float(random.uniform(-1, 1)), float(random.uniform(-1, 1))};
    for (int c = 0; c < 3; c++) {
      Vec p = at;
      for (float& x : p) x = roundTo(x + 0.05 * random.normal(), lattice);
      heap.vertices.push_back(p);
    }
    heap.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const DicedMesh fine = meshOf(dicedSheet(1, 80, lattice), QuadOrder::Rows, random);
  return {{"a sheet of triangles with irregular stripes", partlyIrregular(fine, random, true)},
          {"a sheet of quads with irregular stripes", partlyIrregular(fine, random, false)},
          {"a sheet of triangles", irregularTriangles(sheet, random)},
          {"a sheet of quads", irregularQuads(sheet, random)},
          {"a ball of triangles", irregularTriangles(ball, random)},
          {"a ball of quads", irregularQuads(ball, random)},
          {"a heap of triangles", heap}};
}

} // namespace programs::test
