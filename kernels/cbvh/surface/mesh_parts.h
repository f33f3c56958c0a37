// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Divides a mesh into regions that form grids (quad_regions.h) and irregular primitives, which are stored in mesh
 * blocks (irregular_triangles.h). */

#include "quad_regions.h"

namespace embree
{
  /*! Finds the parts of a mesh. Never null. Throws std::bad_alloc. */
  std::shared_ptr<const QuadRegions> findParts (const QuadMesh* mesh);
  std::shared_ptr<const QuadRegions> findParts (const TriangleMesh* mesh);

  /*! Returns the parts that the geometry's commit found, or finds them again after a build. Throws if out of memory. */
  template<typename Mesh>
  inline std::shared_ptr<const QuadRegions> partsOf (const Mesh* mesh)
  {
    std::shared_ptr<const QuadRegions> found = std::atomic_load(&mesh->surface.regions);
    if (!found) found = findParts(mesh);
    if (found && found->isOutOfMemory)
      throw_RTCError(RTC_ERROR_OUT_OF_MEMORY,"not enough memory to find the grids of a mesh");
    return found;
  }
}
