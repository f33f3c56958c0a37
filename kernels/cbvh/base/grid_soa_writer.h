// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writes uncompressed patches to a BlockStore, as GridSOA: the vertex grids of Embree's GRID. */

#include "../embree/scene.h"
#include "block_store.h"
#include "build_statistics.h"

namespace embree::isa {
class GridSOAWriter {
public:
  static const unsigned gridQuads = 8; //!< quads per side of a full grid, as in Embree's bvh_builder_subdiv.cpp

  /*! countsInvalidQuads: whether statistics count quads with a vertex that is not finite. */
  GridSOAWriter(const SubdivMesh* mesh, BlockStore& store, cbvh::BuildStatistics& statistics, bool countsInvalidQuads)
    : mesh(mesh),
      store(store),
      statistics(statistics),
      countsInvalidQuads(countsInvalidQuads) {}

  void write(const SubdivPatch1Base& patch) const {
    const unsigned x1 = patch.grid_u_res - 1, y1 = patch.grid_v_res - 1;
    for (unsigned y = 0; y < y1; y += gridQuads)
      for (unsigned x = 0; x < x1; x += gridQuads) write(patch, x, min(x + gridQuads, x1), y, min(y + gridQuads, y1));
  }

  /*! Writes one grid. x0, x1, y0, y1: its first and last column and row of vertices in the patch. */
  void write(const SubdivPatch1Base& patch, unsigned x0, unsigned x1, unsigned y0, unsigned y1) const {
    BBox3fa bounds;
    const size_t bvhBytes = GridSOA::getBVHBytes(GridRange(0, x1 - x0, 0, y1 - y0), sizeof(BVH4::AABBNode), 0),
                 gridBytes = 4 * sizeof(float) * size_t(x1 - x0 + 1) *
                             size_t(y1 - y0 + 1); // x, y, z, and both parameters in 32 bits
    void* memory = store.memory->allocate(offsetof(GridSOA, data) + bvhBytes + gridBytes + sizeof(BVH4::NodeRef));
    GridSOA* soa = new (memory)
        GridSOA(&patch, 1, x0, x1, y0, y1, patch.grid_u_res, patch.grid_v_res, mesh, bvhBytes, gridBytes, &bounds);
    statistics.sums.uncompressedBytes += offsetof(GridSOA, data) + soa->rootOffset + sizeof(BVH4::NodeRef);
    statistics.sums.numUncompressedQuads += size_t(x1 - x0) * size_t(y1 - y0);
    store.addPrimitive(bounds, size_t(BVH4::encodeTypedLeaf(soa, cbvh::GRID_SOA_ROOT)));
    if (countsInvalidQuads) statistics.sums.numInvalidQuads += countInvalidQuads(*soa);
  }

  /*! Bytes of a patch's grids in GRID, with their share of the nodes above. quads: quads per side of the patch. */
  static size_t bytesOfPatch(const Vec2i& quads) {
    const unsigned side = gridQuads;
    const unsigned full[2] = {unsigned(quads.x) / side, unsigned(quads.y) / side},
                   remaining[2] = {unsigned(quads.x) % side, unsigned(quads.y) % side};
    size_t bytes = 0;
    if (full[0] && full[1]) bytes += size_t(full[0]) * size_t(full[1]) * bytesOfGrid(side, side);
    if (remaining[0] && full[1]) bytes += full[1] * bytesOfGrid(remaining[0], side);
    if (remaining[1] && full[0]) bytes += full[0] * bytesOfGrid(side, remaining[1]);
    if (remaining[0] && remaining[1]) bytes += bytesOfGrid(remaining[0], remaining[1]);
    return bytes;
  }

private:
  static size_t countInvalidQuads(const GridSOA& grid) {
    const float* const x = grid.gridData();
    auto isInvalid = [&](unsigned i) {
      const float p[3] = {x[i], x[i + grid.dim_offset], x[i + 2 * grid.dim_offset]};
      return !cbvh::isFinite(p);
    };
    size_t count = 0;
    for (unsigned i = 0; i + grid.width < grid.dim_offset; i++)
      if ((i + 1) % grid.width != 0) // no quad begins at the last vertex of a row
        count += isInvalid(i) || isInvalid(i + 1) || isInvalid(i + grid.width) || isInvalid(i + grid.width + 1);
    return count;
  }

  /*! Bytes of a grid of x by y quads, from a table of the 64 sizes that is filled on demand. Threads that compute
   *  an entry at the same time store the same value. */
  static size_t bytesOfGrid(unsigned x, unsigned y) {
    static std::atomic<uint32_t> cached[gridQuads + 1][gridQuads + 1];
    uint32_t bytes = cached[y][x];
    if (bytes == 0) cached[y][x] = bytes = uint32_t(computeBytes(x, y));
    return bytes;
  }

  static size_t computeBytes(unsigned x, unsigned y) {
    // a third of a node: nodes with four children are a third as many as their leaves
    return offsetof(GridSOA, data) + GridSOA::getBVHBytes(GridRange(0, x, 0, y), sizeof(BVH4::AABBNode), 0) +
           4 * sizeof(float) * size_t(x + 1) * size_t(y + 1) + sizeof(BVH4::NodeRef) + sizeof(BVH4::AABBNode) / 3;
  }

  const SubdivMesh* mesh;
  BlockStore& store;
  cbvh::BuildStatistics& statistics;
  const bool countsInvalidQuads;
};
} // namespace embree::isa
