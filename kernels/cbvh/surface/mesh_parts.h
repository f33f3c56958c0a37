// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Primitives that form grids are stored as grids (quad_regions.h), all others in mesh blocks
 * (irregular_triangles.h). */

#include "quad_regions.h"

namespace embree
{
  /*! Finds the grids and the irregular primitives of a mesh. Never null. */
  std::shared_ptr<const QuadRegions> findParts (const QuadMesh* mesh);
  std::shared_ptr<const QuadRegions> findParts (const TriangleMesh* mesh);

  /*! Returns the parts that the commit of a compressed mesh found. Finds them again if a build has released them.
   *  Throws if out of memory. */
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
