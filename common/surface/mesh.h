// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Meshes of quads and triangles that are traced without subdivision. */

#include "surface/cage.h"

#include <array>
#include <string>
#include <vector>

namespace cbvh {

/* Converts all faces to 4 vertices; a triangle repeats its last vertex. Removes holes. Throws Error for a face with
 * more vertices. */
void makeQuads(Cage& cage, const std::string& path);

/* True if a face of such a mesh is a triangle. */
inline bool isTriangle(const Cage& mesh, size_t face)
{
  const unsigned* const v = &mesh.faceIndices[4 * face];
  return v[2] == v[3];
}

/* Returns the spacing, a power of two, of the coarsest lattice that contains all positions, as after storing a mesh as
 * cVERT. Returns 0 if that lattice is as fine as the resolution of the floats. */
float latticeSpacing(const std::vector<Vec3f>& positions);

/* Writes quads and their vertices as OBJ, merging vertices with equal coordinates. Leaves out quads with a vertex that
 * is not finite. Throws Error. */
void writeObj(const std::string& path, const std::vector<Vec3f>& vertices,
              const std::vector<std::array<unsigned, 4>>& quads);

} // namespace cbvh
