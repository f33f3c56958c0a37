// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "mesh_regions.h"
#include "embree_bytes.h"
#include <algorithm>

namespace embree {
namespace {
/*! Moves the quads of regions to the irregular primitives if they need no more bytes in mesh blocks than in grids.
 *  Requires one time step. */
template<typename Mesh>
void moveToMeshBlocks(const Mesh* mesh, QuadRegions& meshRegions) {
  const auto quads = quadsOf(mesh, meshRegions);
  std::vector<bool> isMoved;
  size_t numMoved = 0;
  for (const QuadRegions::Region& region : meshRegions.regions) {
    isMoved.push_back(QuadRegions::isSmallerInMeshBlocks(region));
    if (isMoved.back()) numMoved += size_t(region.width) * region.height;
  }
  // If most quads are moved, the others form grids by accident. In CAD models, such grids took more bytes than
  // estimated, and slowed rays. They stay grids only if they are smaller even with their tables of numbers.
  if (2 * numMoved > meshRegions.quads.size()) {
    cbvh::QuadNumbers numbers;
    cbvh::NumbersEncoder encoder;
    for (size_t i = 0; i < meshRegions.regions.size(); i++)
      if (QuadRegions::dependsOnTables(meshRegions.regions[i]))
        isMoved[i] = QuadRegions::isSmallerInMeshBlocks(meshRegions.regions[i],
                                                        bytesOfTables(quads, meshRegions, i, numbers, encoder));
  }
  if (std::find(isMoved.begin(), isMoved.end(), true) == isMoved.end()) return;
  cbvh::UnmonitoredVector<unsigned> remaining; // not in place: regions are not sorted by `first`
  remaining.reserve(meshRegions.quads.size());
  size_t regions = 0, regular = 0;
  for (size_t i = 0; i < meshRegions.regions.size(); i++) {
    const QuadRegions::Region region = meshRegions.regions[i];
    const unsigned* const quadsOfRegion = meshRegions.quads.data() + region.first;
    const size_t count = size_t(region.width) * region.height;
    if (isMoved[i]) {
      for (size_t k = 0; k < count; k++) {
        const unsigned first = quads.firstPrimID(quadsOfRegion[k]), second = quads.secondPrimID(quadsOfRegion[k]);
        meshRegions.irregular.push_back(first);
        if (second != first) meshRegions.irregular.push_back(second);
      }
      continue;
    }
    meshRegions.regions[regions++] = QuadRegions::Region{remaining.size(), region.width, region.height};
    regular += i < meshRegions.numRegular;
    const size_t begin = remaining.size();
    remaining.resize(begin + count);
    std::copy_n(quadsOfRegion, count, remaining.begin() + begin);
  }
  meshRegions.regions.resize(regions);
  meshRegions.numRegular = regular;
  meshRegions.quads = std::move(remaining);
  std::sort(meshRegions.irregular.begin(), meshRegions.irregular.end());
}

/*! Divides a mesh with one time step region by region (moveToMeshBlocks). Assigns a moving mesh entirely to grids
 *  if these need at most an estimated three quarters of Embree's bytes, otherwise entirely to mesh blocks. Both
 *  estimates are for one time step. bytesInEmbree: per primitive. */
template<typename Mesh>
std::shared_ptr<const QuadRegions> divide(const Mesh* mesh, size_t bytesInEmbree) {
  const std::shared_ptr<const QuadRegions> found = QuadRegions::find(mesh);
  if (mesh->numTimeSteps != 1) {
    const bool areGridsSmaller =
        !found->regions.empty() && 4 * found->bytesOfBlocks() <= 3 * bytesInEmbree * mesh->size();
    if (areGridsSmaller) return found;
    const std::shared_ptr<QuadRegions> meshRegions = std::make_shared<QuadRegions>();
    meshRegions->areAllIrregular = true;
    meshRegions->numInvalid = found->numInvalid;
    return meshRegions;
  }
  const std::shared_ptr<QuadRegions> meshRegions = std::const_pointer_cast<QuadRegions>(found);
  meshRegions->areAllIrregular = meshRegions->regions.empty();
  moveToMeshBlocks(mesh, *meshRegions);
  return meshRegions;
}
} // namespace

std::shared_ptr<const QuadRegions> divideMesh(const QuadMesh* mesh) { return divide(mesh, bytesOfQuadInEmbree(1)); }
std::shared_ptr<const QuadRegions> divideMesh(const TriangleMesh* mesh) {
  return divide(mesh, bytesOfTriangleInEmbree(1));
}
} // namespace embree
