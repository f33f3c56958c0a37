// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Finds the first grid, quad or triangle whose vertices are not finite or do not exist, to name it. Only called if the
 * commit left out something. */

#include "../base/codec_names.h"
#include "../base/surface_statistics.h"
#include "irregular_triangles.h"
#include <algorithm>

namespace embree::isa {
struct InvalidInput {
  size_t primitive;
  cbvh::InvalidVertex vertex;
};

/*! Sets `out` and returns true if a vertex is not finite at a time step, or does not exist. */
template<typename Mesh>
bool isInvalidVertex(const Mesh* mesh, size_t primitive, size_t vertex, InvalidInput& out) {
  for (unsigned step = 0; step < mesh->numTimeSteps; step++) {
    const BufferView<Vec3fa>& vertices = mesh->vertices[step];
    if (vertex < vertices.size() && cbvh::isFinite((const float*)vertices.getPtr(vertex))) continue;
    out.primitive = primitive;
    out.vertex.vertex = unsigned(std::min(vertex, size_t(~0u - 1)));
    out.vertex.timeStep = step;
    return true;
  }
  return false;
}

template<typename Mesh, typename Indices>
bool findInvalidIndexed(const Mesh* mesh, const Indices& primitives, int verticesPerPrimitive, InvalidInput& out) {
  for (size_t i = 0; i < primitives.size(); i++)
    for (int k = 0; k < verticesPerPrimitive; k++)
      if (isInvalidVertex(mesh, i, primitives[i].v[k], out)) return true;
  return false;
}

/*! Returns false if all vertices are valid. */
inline bool findInvalid(const QuadMesh* mesh, InvalidInput& out) {
  return findInvalidIndexed(mesh, mesh->quads, 4, out);
}
inline bool findInvalid(const TriangleMesh* mesh, InvalidInput& out) {
  return findInvalidIndexed(mesh, mesh->triangles, 3, out);
}
inline bool findInvalid(const GridMesh* mesh, InvalidInput& out) {
  for (size_t i = 0; i < mesh->grids.size(); i++) {
    const GridMesh::Grid& grid = mesh->grid(i);
    if (grid.resX < 2 || grid.resY < 2) continue;
    for (size_t y = 0; y < grid.resY; y++)
      for (size_t x = 0; x < grid.resX; x++)
        if (isInvalidVertex(mesh, i, grid.startVtxID + y * grid.lineVtxOffset + x, out)) return true;
  }
  return false;
}
} // namespace embree::isa
