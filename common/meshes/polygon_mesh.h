// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A mesh as its file has it: polygons, and coordinates of 64 bits. All readers of meshes return it. */

#include "basics/vec.h"

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstddef>
#include <string>
#include <vector>

namespace programs {

struct PolygonMesh {
  std::vector<Vec3d> positions;
  std::vector<unsigned> faceSizes;   // vertices per face, at least 3
  std::vector<unsigned> faceIndices; // into positions

  std::string comments;           // of the head of its file, one per line
  std::string up;                 // "x", "y" or "z" if the format defines the up axis, else ""
  bool splitsAreExplicit = false; // quads must be split between their corners 2 and 4, even if they are concave

  size_t numFaces() const { return faceSizes.size(); }

  /* For that many more triangles. */
  void reserveTriangles(size_t count) {
    const auto grow = [](std::vector<unsigned>& all, size_t more) {
      if (all.size() + more > all.capacity()) all.reserve(std::max(all.size() + more, 2 * all.capacity()));
    };
    grow(faceSizes, count);
    grow(faceIndices, 3 * count);
  }

  void addTriangle(unsigned a, unsigned b, unsigned c) {
    faceSizes.push_back(3);
    faceIndices.insert(faceIndices.end(), {a, b, c});
  }
};

/* Indices have 32 bits, and the largest one means "none". */
constexpr unsigned long long mostMeshElements = 0xFFFFFFFEull;

/* Rays are traced in 32 bits, so readers reject what 32 bits cannot hold, and NaN. */
inline bool isCoordinate(double x) { return std::abs(x) <= double(FLT_MAX); }

/* Adds the triangles of a strip. Their orientation alternates. Triangles that contain a vertex twice only connect
 * parts of a strip, and are left out. */
class StripTriangles {
public:
  explicit StripTriangles(PolygonMesh& mesh) : mesh(mesh) {}

  void add(unsigned vertex) {
    if (count >= 2 && previous[0] != previous[1] && previous[1] != vertex && previous[0] != vertex) {
      if (count % 2 == 0) mesh.addTriangle(previous[0], previous[1], vertex);
      else mesh.addTriangle(previous[1], previous[0], vertex);
    }
    previous[0] = previous[1];
    previous[1] = vertex;
    count++;
  }

  /* The next vertex begins a new strip. */
  void restart() { count = 0; }

  size_t size() const { return count; }

private:
  PolygonMesh& mesh;
  unsigned previous[2] = {};
  size_t count = 0;
};

} // namespace programs
