// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Meshes that are traced as they are: quads and triangles, no subdivision. */

#include "surface/cage.h"

#include <array>
#include <string>
#include <vector>

namespace cbvh {

/* Gives all faces of what was read 4 vertices; triangles have the last of theirs twice. Leaves out those that are holes. Throws Error that names
 * a face of more. */
void makeQuads(Cage& cage, const std::string& path);

/* Whether a face of such a mesh is a triangle. */
inline bool isTriangle(const Cage& mesh, size_t face) { return mesh.faceIndices[4 * face + 2] == mesh.faceIndices[4 * face + 3]; }

/* Spacing, a power of two, of the coarsest lattice on which all positions lie, as those of a mesh do that was stored as cVERT; 0 where
 * that would be no coarser than what their floats resolve. */
float latticeSpacing(const std::vector<Vec3f>& positions);

/* Writes quads around their vertices as OBJ, with one vertex for all that are the same floats; quads with a vertex that is not
 * finite are left out. Throws Error, Cancelled. */
void writeObj(const std::string& path, const std::vector<Vec3f>& vertices, const std::vector<std::array<unsigned, 4>>& quads);

} // namespace cbvh
