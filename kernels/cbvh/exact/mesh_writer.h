// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Writer of mesh blocks or mesh tiles: rounds and encodes clusters (cvert/encoder/mesh_partition.h) of irregular
 * triangles (surface/irregular_triangles.h), and appends the blocks to a store. One writer per task. */

#include "../base/block_bytes.h"
#include "../base/block_store.h"
#include "../base/build_statistics.h"
#include "../surface/irregular_triangles.h"
#include "../../cvert/conversion/mesh_tile_conversion.h"

namespace embree::isa {
class MeshWriter {
public:
  static const uint32_t trianglesPerGroup = 16; //!< of a full group

  /*! The arguments must outlive the writer. */
  MeshWriter(const IrregularTriangles& source, const CompressionPlan& plan, BlockStore& store,
             cbvh::BuildStatistics& statistics)
    : source(source),
      surfaceNumber(plan.surfaceNumber),
      makesTiles(plan.makesTiles()),
      store(store),
      statistics(statistics) {}

  /*! Primitives of a full group. A primitive is a triangle or a quad. */
  static uint32_t primitivesPerGroup(const TrianglesOfMesh& mesh) {
    return trianglesPerGroup / mesh.trianglesPerPrimitive;
  }

  /*! Writes a cluster. groups: its division into groups of consecutive primitives. The caller must flush the store
   *  after the last cluster: a single flush leaves less memory unused. */
  void write(const cbvh::MeshCenter* cluster, const cbvh::MeshGroups& groups) {
    double squaredDeviation = 0; // largest squared distance by which rounding moved a corner
    uint32_t numTriangles = 0;
    const cbvh::MeshGroups stored = storeGroups(groups, numTriangles, [&](uint32_t i) {
      for (uint32_t k = 0; k < source.mesh.trianglesPerPrimitive; k++) {
        cbvh::MeshTriangle& triangle = triangles[numTriangles];
        triangle.number = source.mesh.triangleOf(cluster[i].index, k);
        squaredDeviation = max(squaredDeviation, source.snapCorners(triangle.number, triangle.corners));
        const float(&c)[3][3] = triangle.corners; // a quad's empty half, or equal after rounding: not stored
        numTriangles += !cbvh::MeshLattice::isDegenerate(c[0], c[1], c[2]);
      }
    });
    statistics.addDeviation(squaredDeviation);
    if (numTriangles == 0) return;
    cbvh::MeshStatistics meshStatistics;
    encoder.encodeCluster(
        triangles, stored, source.mesh.areHalvesOfQuads(), surfaceNumber, block, meshStatistics,
        [&](size_t bytes, uint32_t first, uint32_t count) { commitBlock(bytes, triangles + first, count); });
  }

  /*! Calls storePrimitive(i) for each primitive i of a cluster. The call must add the number of triangles that it
   *  stores to numTriangles. Returns the groups of the stored triangles. */
  template<typename StorePrimitive>
  static cbvh::MeshGroups storeGroups(const cbvh::MeshGroups& groups, const uint32_t& numTriangles,
                                      const StorePrimitive& storePrimitive) {
    cbvh::MeshGroups stored;
    uint32_t i = 0;
    for (uint32_t g = 0; g < groups.count; g++) {
      const uint32_t before = numTriangles;
      while (i < groups.ends[g]) storePrimitive(i++);
      if (numTriangles != before) stored.add(numTriangles);
    }
    return stored;
  }

  /*! header: of a mesh block or mesh tile. bytes: its size without padding. */
  template<typename Header>
  static void addToStatistics(const Header* header, size_t bytes, cbvh::BuildStatistics& statistics) {
    cbvh::BlockBytes(header, bytes).addTo(statistics.sums);
    statistics.sums.numBlocks++;
  }

private:
  /*! Stores the encoded block. blockTriangles: its `count` triangles, with rounded corners. */
  void commitBlock(size_t bytes, const cbvh::MeshTriangle* blockTriangles, uint32_t count) {
    cbvh::WorldBounds bounds;
    for (uint32_t i = 0; i < count; i++)
      for (const float(&p)[3] : blockTriangles[i].corners) bounds.extend(p[0], p[1], p[2]);
    if (source.mesh.areHalvesOfQuads()) ((cbvh::MeshHeader*)block)->info |= cbvh::meshHasQuads;
    store.hitBounds.extend(bounds);
    if (makesTiles && commitTile(toBBox(bounds))) return;
    store.add(block, bytes, toBBox(bounds), cbvh::MESH_BLOCK, cbvh::vertReadPadding);
    addToStatistics((const cbvh::MeshHeader*)block, bytes, statistics);
  }

  /*! Stores the encoded block as a tile. Returns false if it has none. */
  bool commitTile(const BBox3fa& bounds) {
    uint8_t* const tile = store.reserve(cbvh::maxBytesOfMeshTile);
    const size_t bytes = cbvh::tileOfMesh((const cbvh::MeshHeader*)block, tile);
    if (bytes == 0) return false;
    addToStatistics((const cbvh::MeshTileHeader*)tile, bytes, statistics);
    store.commit(bytes, bounds, cbvh::TILE_BLOCK, cbvh::meshTileReadPadding);
    return true;
  }

  const IrregularTriangles& source;
  const uint32_t surfaceNumber;
  const bool makesTiles;
  BlockStore& store;
  cbvh::BuildStatistics& statistics;
  cbvh::MeshEncoder encoder;
  cbvh::MeshTriangle triangles[cbvh::maxMeshTriangles + 1]; //!< one more than clusters have
  alignas(16) uint8_t block[cbvh::MeshEncoder::maxBytes];
};
} // namespace embree::isa
