// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Divides a mesh into regions that form grids (quad_regions.h) and irregular primitives, which are stored in mesh
 * blocks (irregular_triangles.h). */

#include "quad_regions.h"

namespace embree {
/*! A moving mesh is stored entirely in grids or entirely in mesh blocks. Never null. Throws std::bad_alloc. */
std::shared_ptr<const QuadRegions> divideMesh(const QuadMesh* mesh);
std::shared_ptr<const QuadRegions> divideMesh(const TriangleMesh* mesh);

/*! Returns the result of divideMesh() from the geometry's commit, or calls it again if a build has released it.
 *  Never null. Throws rtcore_error if memory ran out in the commit, otherwise as divideMesh(). Mesh: QuadMesh or
 *  TriangleMesh. */
template<typename Mesh>
inline std::shared_ptr<const QuadRegions> regionsOf(const Mesh* mesh) {
  std::shared_ptr<const QuadRegions> found = std::atomic_load(&mesh->surface.regions);
  if (!found) found = divideMesh(mesh);
  if (found->isOutOfMemory) throw_RTCError(RTC_ERROR_OUT_OF_MEMORY, "not enough memory to find the grids of a mesh");
  return found;
}
} // namespace embree
