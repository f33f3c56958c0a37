// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* mesh_writer.h for moving meshes: rounds the vertices of a cluster at all time steps, and stores moving mesh blocks
 * (cvert/format/mesh_motion.h) and their boxes at each step. */

#include "../../cvert/conversion/moving_mesh_tile_conversion.h"
#include "mesh_writer.h"

namespace embree::isa {
class MovingMeshWriter {
public:
  /*! The arguments must outlive the writer. */
  MovingMeshWriter(const IrregularTriangles& source, const CompressionPlan& plan, BlockStore& store,
                   cbvh::BuildStatistics& statistics)
    : source(source),
      plan(plan),
      store(store),
      statistics(statistics),
      boxes(plan.numTimeSteps, emptyBox()),
      words(cbvh::MeshMotionEncoder::maxBytes(plan.numTimeSteps) / sizeof(uint32_t) + 1) {}

  /*! Writes a cluster of MeshClusters. The caller must flush the store after the last cluster. */
  void write(const cbvh::MeshCenter* cluster, const cbvh::MeshGroups& groups) {
    double squaredDeviation = 0; // largest squared distance by which rounding moved a vertex
    uint32_t numTriangles = 0;
    const cbvh::MeshGroups stored = MeshWriter::storeGroups(groups, numTriangles, [&](uint32_t i) {
      for (uint32_t k = 0; k < source.mesh.trianglesPerPrimitive; k++) {
        const uint32_t number = source.mesh.triangleOf(cluster[i].index, k);
        if (source.haveEqualCorners(number)) continue; // a quad with three corners has one triangle
        cbvh::MeshTriangle& triangle = triangles[numTriangles];
        uint32_t(&cornerIDs)[3] = ids[numTriangles++];
        triangle.number = number;
        source.cornerIDs(number, cornerIDs);
        for (int c = 0; c < 3; c++)
          squaredDeviation = max(squaredDeviation, source.snapVertex(0, cornerIDs[c], triangle.corners[c]));
      }
    });
    if (numTriangles == 0) return;
    const cbvh::MovingCluster movingCluster = {triangles,
                                               ids,
                                               stored,
                                               source.mesh.areHalvesOfQuads(),
                                               plan.surfaceNumber,
                                               plan.timeRange.lower,
                                               plan.timeRange.upper,
                                               plan.numTimeSteps};
    cbvh::MeshStatistics meshStatistics;
    encoder.encodeCluster(
        movingCluster, (uint8_t*)words.data(), meshStatistics,
        [&](uint32_t step, uint32_t id, float out[3]) {
          squaredDeviation = max(squaredDeviation, source.snapVertex(step, id, out));
          extend(boxes[step], out);
        },
        [&](size_t bytes, uint32_t first, uint32_t count) { commitBlock(bytes, first, count); });
    statistics.addDeviation(squaredDeviation);
    store.flushIfFull();
  }

private:
  static cbvh::StepBox emptyBox() { return {{pos_inf, pos_inf, pos_inf}, {neg_inf, neg_inf, neg_inf}}; }

  static void extend(cbvh::StepBox& box, const float p[3]) {
    for (int k = 0; k < 3; k++) {
      box.lower[k] = min(box.lower[k], p[k]);
      box.upper[k] = max(box.upper[k], p[k]);
    }
  }

  /*! Stores the encoded block. first, count: its triangles. Requires `boxes` of all steps but the first. */
  void commitBlock(size_t bytes, uint32_t first, uint32_t count) {
    for (uint32_t i = first; i < first + count; i++)
      for (const float(&corner)[3] : triangles[i].corners) extend(boxes[0], corner);
    cbvh::WorldBounds bounds;
    for (cbvh::StepBox& box : boxes) {
      bounds.extend(box.lower[0], box.lower[1], box.lower[2]);
      bounds.extend(box.upper[0], box.upper[1], box.upper[2]);
      store.boxes.push_back(box);
      box = emptyBox();
    }
    cbvh::MeshHeader* const header = (cbvh::MeshHeader*)words.data();
    if (source.mesh.areHalvesOfQuads()) header->info |= cbvh::meshHasQuads;
    store.hitBounds.extend(bounds);
    if (plan.makesTiles() && commitTile(header, toBBox(bounds))) return;
    store.add(header, bytes, toBBox(bounds), cbvh::MESH_BLOCK, cbvh::vertReadPadding);
    statistics.sums.motionBytes += cbvh::laterStepBytes(header);
    MeshWriter::addToStatistics(header, bytes, statistics);
  }

  /*! Stores the encoded block as a tile. Returns false if it has none. */
  bool commitTile(const cbvh::MeshHeader* block, const BBox3fa& bounds) {
    uint8_t* const bytes = store.reserve(cbvh::maxBytesOfMovingMeshTile(plan.numTimeSteps));
    const size_t size = tileWriter.write(block, bytes);
    if (size == 0) return false;
    const cbvh::MeshTileHeader* const tile = (const cbvh::MeshTileHeader*)bytes;
    statistics.sums.motionBytes += cbvh::laterStepBytes(tile);
    MeshWriter::addToStatistics(tile, size, statistics);
    store.commit(size, bounds, cbvh::TILE_BLOCK, cbvh::meshTileReadPadding);
    return true;
  }

  const IrregularTriangles& source;
  const CompressionPlan& plan;
  BlockStore& store;
  cbvh::BuildStatistics& statistics;
  cbvh::MeshMotionEncoder encoder;
  cbvh::MovingMeshTileWriter tileWriter;
  cbvh::MeshTriangle triangles[cbvh::maxMeshTriangles];
  uint32_t ids[cbvh::maxMeshTriangles][3]; //!< IrregularTriangles::cornerIDs() of the triangles
  std::vector<cbvh::StepBox> boxes;        //!< of the current block, by step
  std::vector<uint32_t> words;             //!< the encoded block
};
} // namespace embree::isa
