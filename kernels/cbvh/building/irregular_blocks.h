// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Builds mesh blocks (cvert/format/mesh_block.h) of the triangles that are in no grid. All threads first divide the
 * triangles into batches, by position. A task then clusters and encodes each batch. */

#include "../surface/mesh_regions.h"
#include "../exact/moving_mesh_writer.h"
#include "build_results.h"

namespace embree::isa {
class IrregularBlocks {
public:
  /*! regions: must have irregular primitives. plan must outlive this object. */
  IrregularBlocks(const TrianglesOfMesh& mesh, const std::shared_ptr<const QuadRegions>& regions,
                  const CompressionPlan& plan, Device* device)
    : device(device),
      plan(plan),
      regions(regions),
      triangles(mesh, regions->areAllIrregular ? nullptr : &regions->irregular, plan, device) {}

  size_t numPrimitives() const { return triangles.numPrimitives(); }
  size_t estimateBlocks() const {
    return (triangles.numTriangles() + cbvh::maxMeshTriangles - 1) / cbvh::maxMeshTriangles;
  }

  /*! borders: borders of the geometry's grids, which must remain valid until build() returns, or null */
  template<typename Progress>
  void prepare(const StoredBorders* borders, const Progress& progress) {
    triangles.prepare(borders, [&] { progress(0.0); });
  }
  void release() { triangles.release(); }

  /*! Adds blocks and statistics to `results`, after the blocks of the geometry's numGrids grids. Call it once,
   *  after prepare(): it reorders the primitives. progress: as in SurfaceBuilder::build(). */
  template<typename Progress>
  void build(cbvh::BlockMemory& memory, BuildResults& results, size_t numGrids, const Progress& progress) {
    const uint32_t group = MeshWriter::primitivesPerGroup(triangles.mesh);
    std::vector<range<size_t>> batches;
    if (triangles.centers.size()) batches.push_back(range<size_t>(0, triangles.centers.size()));
    for (uint32_t depth = 0; divide(group, depth, batches); depth++) progress(0.0);
    if (batches.empty()) progress(double(numPrimitives())); // no primitive can be hit
    const double perCenter = double(numPrimitives()) / double(max(triangles.centers.size(), size_t(1)));
    parallel_for(size_t(0), batches.size(), size_t(1), [&](const range<size_t>& r) {
      cbvh::MeshClusters clusters(group);
      for (size_t i = r.begin(); i != r.end(); i++) {
        BlockStore store(device, &memory);
        cbvh::BuildStatistics statistics;
        // on the heap, because writers are large
        if (plan.moves())
          write(clusters, batches[i],
                std::unique_ptr<MovingMeshWriter>(new MovingMeshWriter(triangles, plan, store, statistics)));
        else
          write(clusters, batches[i], std::unique_ptr<MeshWriter>(new MeshWriter(triangles, plan, store, statistics)));
        results.add(numGrids + i, 0, 0, store);
        results.add(statistics);
        progress(perCenter * double(batches[i].size()));
      }
    });
    cbvh::BuildStatistics statistics;
    statistics.bytesInEmbree = triangles.bytesInEmbree();
    // statistics count quads: two triangles count as one
    const bool areQuads = triangles.mesh.areHalvesOfQuads();
    const size_t quads = areQuads ? triangles.centers.size() : (triangles.centers.size() + 1) / 2;
    statistics.sums.numQuads = statistics.sums.numMeshQuads = statistics.sums.numIrregularQuads = quads;
    if (plan.moves()) statistics.sums.numMovingQuads = quads;
    statistics.sums.numInvalidQuads = areQuads ? triangles.numInvalid : (triangles.numInvalid + 1) / 2;
    statistics.sums.maxVertexSpacing = triangles.spacing();
    results.add(statistics);
  }

private:
  struct BoundsOf {
    const IrregularTriangles& triangles;

    void operator()(uint32_t primitive, float lower[3], float upper[3]) const {
      triangles.bounds(primitive, lower, upper);
    }
  };

  BoundsOf boundsOf() const { return BoundsOf{triangles}; }

  template<typename Writer>
  void write(cbvh::MeshClusters& clusters, const range<size_t>& batch, const std::unique_ptr<Writer>& writer) {
    clusters.split(
        triangles.centers.data() + batch.begin(), batch.size(), boundsOf(),
        [&](const cbvh::MeshCenter* cluster, const cbvh::MeshGroups& groups) { writer->write(cluster, groups); });
  }

  /*! Splits each batch that is too large for a task in two. Returns false if no batch is too large. group:
   *  primitives of a full group. depth: number of previous calls. */
  bool divide(uint32_t group, uint32_t depth, std::vector<range<size_t>>& batches) {
    std::vector<size_t> halves(batches.size(), 0);
    parallel_for(size_t(0), batches.size(), size_t(1), [&](const range<size_t>& r) {
      cbvh::MeshClusters clusters(group);
      for (size_t i = r.begin(); i != r.end(); i++)
        if (batches[i].size() > cbvh::MeshClusters::batchTriangles)
          halves[i] =
              clusters.splitOnce(triangles.centers.data() + batches[i].begin(), batches[i].size(), boundsOf(), depth);
    });
    std::vector<range<size_t>> next;
    for (size_t i = 0; i < batches.size(); i++) {
      const size_t middle = batches[i].begin() + halves[i];
      if (halves[i]) next.push_back(range<size_t>(batches[i].begin(), middle));
      next.push_back(range<size_t>(middle, batches[i].end()));
    }
    const bool changed = next.size() != batches.size();
    batches.swap(next);
    return changed;
  }

  Device* const device;
  const CompressionPlan& plan;
  const std::shared_ptr<const QuadRegions> regions;
  IrregularTriangles triangles;
};
} // namespace embree::isa
