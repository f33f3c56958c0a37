// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "mesh_parts.h"
#include "embree_bytes.h"
#include <algorithm>

namespace embree
{
  namespace
  {
    /*! Moves the quads of regions that need less memory in mesh blocks to the irregular primitives. */
    template<typename Mesh>
    void moveToMeshBlocks (const Mesh* mesh, QuadRegions& parts)
    {
      const auto quads = quadsOf(mesh,parts);
      std::vector<bool> isMoved;
      size_t numMoved = 0;
      for (const QuadRegions::Region& region : parts.regions) {
        isMoved.push_back(QuadRegions::isSmallerInMeshBlocks(region));
        if (isMoved.back()) numMoved += size_t(region.width)*region.height;
      }
      // If most quads are irregular, the others are regular by accident. In CAD models, such grids took more bytes than
      // estimated, and slowed rays. They stay grids only if they are smaller even with their tables of numbers.
      if (2*numMoved > parts.quads.size())
      {
        cbvh::QuadNumbers numbers;
        cbvh::NumbersEncoder encoder;
        for (size_t i=0; i<parts.regions.size(); i++)
          if (QuadRegions::dependsOnTables(parts.regions[i]))
            isMoved[i] = QuadRegions::isSmallerInMeshBlocks(parts.regions[i],
              bytesOfTables(quads,parts,i,numbers,encoder));
      }
      if (std::find(isMoved.begin(),isMoved.end(),true) == isMoved.end()) return;
      cbvh::UnmonitoredVector<unsigned> remaining; // regions are not in the order of their quads
      remaining.reserve(parts.quads.size());
      size_t regions = 0, regular = 0;
      for (size_t i=0; i<parts.regions.size(); i++)
      {
        const QuadRegions::Region region = parts.regions[i];
        const unsigned* const quadsOfRegion = parts.quads.data()+region.first;
        const size_t count = size_t(region.width)*region.height;
        if (isMoved[i]) {
          for (size_t k=0; k<count; k++) {
            const unsigned first = quads.firstPrimID(quadsOfRegion[k]), second = quads.secondPrimID(quadsOfRegion[k]);
            parts.irregular.push_back(first);
            if (second != first) parts.irregular.push_back(second);
          }
          continue;
        }
        parts.regions[regions++] = QuadRegions::Region{ remaining.size(),region.width,region.height };
        regular += i < parts.numRegular;
        const size_t begin = remaining.size();
        remaining.resize(begin+count);
        std::copy_n(quadsOfRegion,count,remaining.begin()+begin);
      }
      parts.regions.resize(regions);
      parts.numRegular = regular;
      parts.quads = std::move(remaining);
      std::sort(parts.irregular.begin(),parts.irregular.end());
    }

    /*! Stores a moving mesh entirely in grids if these need at most an estimated three quarters of Embree's bytes,
     *  otherwise entirely in mesh blocks. bytesInEmbree: per primitive, for one time step. */
    template<typename Mesh>
    std::shared_ptr<const QuadRegions> findPartsOf (const Mesh* mesh, size_t bytesInEmbree)
    {
      const std::shared_ptr<const QuadRegions> found = QuadRegions::find(mesh);
      if (mesh->numTimeSteps != 1) {
        const bool areGridsSmaller =
          !found->regions.empty() && 4*found->bytesOfBlocks() <= 3*bytesInEmbree*mesh->size();
        if (areGridsSmaller || found->isOutOfMemory) return found;
        const std::shared_ptr<QuadRegions> parts = std::make_shared<QuadRegions>();
        parts->areAllIrregular = true;
        parts->numInvalid = found->numInvalid;
        return parts;
      }
      const std::shared_ptr<QuadRegions> parts = std::const_pointer_cast<QuadRegions>(found);
      parts->areAllIrregular = parts->regions.empty();
      moveToMeshBlocks(mesh,*parts);
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
