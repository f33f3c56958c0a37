// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "surface/cage.h"

#include <array>
#include <string>
#include <vector>

namespace programs {

/* Requires faces of 4 vertices; triangles repeat the last one. */
inline bool isTriangle(const Cage& mesh, size_t face) {
  const unsigned* const v = &mesh.faceIndices[4 * face];
  return v[2] == v[3];
}

/* Spacing, a power of two, of the coarsest lattice that contains all positions, as after cVERT; 0 if it is as fine
 * as the floats. */
float latticeSpacing(const std::vector<Vec3f>& positions);

/* A comment of files by writeObj: readers must not choose another diagonal. */
constexpr const char* objSplitComment = "quads are split between corners 2 and 4";

/* Writes OBJ. Merges vertices with equal coordinates; omits quads with a vertex that is not finite. Throws Error. */
void writeObj(const std::string& path, const std::vector<Vec3f>& vertices,
              const std::vector<std::array<unsigned, 4>>& quads);

} // namespace programs
