// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest ISA only. */

#include "mesh_parts.h"
#include "embree_bytes.h"
#include "../../cvert/format/block.h"

namespace embree
{
  namespace
  {
    /*! Estimate of the bytes of a region's blocks, if its numbers follow a pattern. */
    size_t bytesOfBlocks (const QuadRegions::Region& region) {
      return bytesOfGridBlocks(region.width,region.height,true);
    }

    template<typename Mesh>
    std::shared_ptr<const QuadRegions> findPartsOf (const Mesh* mesh, size_t bytesInEmbree)
    {
      const std::shared_ptr<const QuadRegions> regions = QuadRegions::find(mesh);
      size_t bytes = 0;
      if (regions)
        for (const QuadRegions::Region& region : regions->regions) bytes += bytesOfBlocks(region);
      if (regions && 4*bytes <= 3*bytesInEmbree*mesh->size()) return regions;
      if (mesh->numTimeSteps != 1) return nullptr;
      const std::shared_ptr<QuadRegions> loose = std::make_shared<QuadRegions>(mesh->device);
      loose->areAllLoose = true;
      return loose;
    }
  }

  std::shared_ptr<const QuadRegions> findParts (const QuadMesh* mesh) { return findPartsOf(mesh,bytesOfQuadInEmbree(1)); }
  std::shared_ptr<const QuadRegions> findParts (const TriangleMesh* mesh) {
    return findPartsOf(mesh,bytesOfTriangleInEmbree(1));
  }
}
