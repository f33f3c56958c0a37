// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How the primitives of a mesh are stored: those that lie like a grid's as grids (quad_regions.h), the others in mesh
 * blocks (loose_triangles.h). */

#include "quad_regions.h"

namespace embree
{
  /*! Finds the grids of a mesh, and its loose primitives. Returns null for a mesh that Embree's own kernel should
   *  keep. */
  std::shared_ptr<const QuadRegions> findParts (const QuadMesh* mesh);
  std::shared_ptr<const QuadRegions> findParts (const TriangleMesh* mesh);

  /*! Returns the parts that the commit of a compressed mesh found. Finds them again if a build has released them.
   *  Throws if memory is exhausted. */
  template<typename Mesh>
  inline std::shared_ptr<const QuadRegions> partsOf (const Mesh* mesh)
  {
    std::shared_ptr<const QuadRegions> found = std::atomic_load(&mesh->surface.regions);
    if (!found) found = findParts(mesh);
    if (found && found->isOutOfMemory)
      throw_RTCError(RTC_ERROR_OUT_OF_MEMORY,"not enough memory to find the grids of a mesh");
    return found ? found : std::make_shared<const QuadRegions>();
  }
}
