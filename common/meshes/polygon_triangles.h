// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Splits polygons into the triangles and quads that rays are traced through. */

#include "meshes/polygon_mesh.h"

#include <vector>

namespace programs {

struct MeshPrimitives {
  unsigned corners = 3;          // per primitive: 4 unless all faces are triangles
  std::vector<unsigned> indices; // a triangle in a mesh of 4 corners repeats its last vertex
  std::vector<unsigned> faces;   // of each primitive in the mesh; empty if primitive i is face i

  size_t size() const { return indices.size() / corners; }
};

/* Triangles and quads stay one primitive. A quad is split between its corners 2 and 4 when it is traced. If it is flat
 * and concave at corner 1 or 3, it begins with its second corner instead, so that it is split inside. Larger faces
 * become triangles: by ears in the plane of their normal, so that concave ones are covered exactly. The mesh loses its
 * faces. */
MeshPrimitives splitPolygons(PolygonMesh& mesh);

} // namespace programs
