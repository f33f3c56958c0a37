// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compiled for the library's lowest ISA only. */

#include "mesh_parts.h"
#include "embree_bytes.h"
#include <algorithm>

namespace embree
{
  namespace
  {
    /*! Estimate of the bytes of a region's blocks, if its numbers follow a pattern. */
    size_t bytesOfBlocks (const QuadRegions::Region& region) {
      return bytesOfGridBlocks(region.width,region.height,true);
    }

    void addPrimitives (const QuadsOfMesh& quads, unsigned quad, mvector<unsigned>& out) {
      out.push_back(quads.number(quad));
    }

    void addPrimitives (const PairsOfMesh& pairs, unsigned pair, mvector<unsigned>& out)
    {
      out.push_back(pairs.number(pair));
      if (!pairs.isSingle(pair)) out.push_back(pairs.number(pair)+1);
    }

    /*! Moves quads of regions that take less memory in mesh blocks to the loose primitives. */
    template<typename Quads>
    void loosen (QuadRegions& parts, const Quads& quads)
    {
      size_t regions = 0, kept = 0;
      for (const QuadRegions::Region& region : parts.regions)
      {
        const unsigned* const of = parts.quads.data()+region.first;
        const size_t count = size_t(region.width)*region.height;
        if (bytesOfBlocks(region) >= bytesOfMeshTriangles(2*count)) {
          for (size_t i=0; i<count; i++) addPrimitives(quads,of[i],parts.loose);
          continue;
        }
        std::copy(of,of+count,parts.quads.begin()+kept); // forwards: kept is not after first
        parts.regions[regions++] = QuadRegions::Region{ kept,region.width,region.height };
        kept += count;
      }
      parts.regions.resize(regions);
      parts.quads.resize(kept);
      std::sort(parts.loose.begin(),parts.loose.end());
    }

    QuadsOfMesh quadsOf (const QuadMesh* mesh, const QuadRegions&) { return QuadsOfMesh{ mesh }; }
    PairsOfMesh quadsOf (const TriangleMesh* mesh, const QuadRegions& parts) { return parts.pairs(mesh); }

    template<typename Mesh>
    std::shared_ptr<const QuadRegions> findPartsOf (const Mesh* mesh, size_t bytesInEmbree)
    {
      const std::shared_ptr<const QuadRegions> found = QuadRegions::find(mesh);
      if (mesh->numTimeSteps != 1)
      {
        size_t bytes = 0;
        if (found)
          for (const QuadRegions::Region& region : found->regions) bytes += bytesOfBlocks(region);
        return found && 4*bytes <= 3*bytesInEmbree*mesh->size() ? found : nullptr;
      }
      const std::shared_ptr<QuadRegions> parts = found ? std::const_pointer_cast<QuadRegions>(found)
        : std::make_shared<QuadRegions>(mesh->device);
      if (found) loosen(*parts,quadsOf(mesh,*parts));
      parts->areAllLoose = !found;
      return parts;
    }
  }

  std::shared_ptr<const QuadRegions> findParts (const QuadMesh* mesh) {
    return findPartsOf(mesh,bytesOfQuadInEmbree(1));
  }
  std::shared_ptr<const QuadRegions> findParts (const TriangleMesh* mesh) {
    return findPartsOf(mesh,bytesOfTriangleInEmbree(1));
  }
}
