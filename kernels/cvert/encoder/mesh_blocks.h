// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Encodes a triangle mesh as mesh blocks: snaps vertices, omits triangles that no ray can hit, and clusters others. */

#include "mesh_partition.h"
#include "mesh_encoder.h"
#include "mesh_lattice.h"
#include <memory>
#include <vector>

namespace cvert { inline namespace CVERT_ISA {
/*! The application's mesh, which must remain valid while it is encoded. */
struct MeshSource {
  const float (*vertices)[3];
  size_t numVertices;
  const uint32_t (*triangles)[3];
  size_t numTriangles; //!< at most 2^32
};

struct MeshSettings {
  int exponent = losslessExponent; //!< minLatticeExponent to maxLatticeExponent, or losslessExponent
  uint32_t groupTriangles = 16;    //!< triangles per full group, a power of two up to maxGroupTriangles
  uint32_t surface = 0;            //!< surface number of the blocks (format/limits.h)
};

struct MeshReport {
  MeshStatistics statistics;
  size_t invalidTriangles = 0;    //!< omitted: index out of range, or vertex not finite
  size_t degenerateTriangles = 0; //!< omitted: two corners are equal, before or after snapping
  size_t finerVertices = 0;       //!< exceptions of MeshLattice, also from earlier calls of encode()
};

class MeshBlocks {
public:
  explicit MeshBlocks(const MeshSettings& settings)
    : settings(settings),
      lattice(settings.exponent),
      encoder(new MeshEncoder) {}

  /*! Calls onBlock(const MeshHeader*) for each block, which is valid during the call. A triangle's number is its
   *  index in `mesh`. Uses 16 temporary bytes per triangle. Throws std::bad_alloc. */
  template<typename OnBlock>
  MeshReport encode(const MeshSource& mesh, const OnBlock& onBlock) {
    MeshReport report;
    std::vector<MeshCenter> centers;
    centers.reserve(mesh.numTriangles);
    for (size_t i = 0; i < mesh.numTriangles; i++) add(mesh, i, centers, report);
    if (lattice.numExceptions() > 0) refineUntilNoneFlips(mesh, centers);
    if (hasFlat) removeCollapsed(mesh, centers, report);
    report.finerVertices = lattice.numExceptions();
    MeshClusters clusters(settings.groupTriangles);
    clusters.split(
        centers.data(), centers.size(),
        [&](uint32_t index, float lower[3], float upper[3]) { bounds(mesh, index, lower, upper); },
        [&](const MeshCenter* cluster, const MeshGroups& groups) {
          encodeCluster(mesh, cluster, groups, report.statistics, onBlock);
        });
    return report;
  }

private:
  /*! Adds the center of triangle i, or counts the triangle as omitted. */
  void add(const MeshSource& mesh, size_t i, std::vector<MeshCenter>& centers, MeshReport& report) {
    const uint32_t* const t = mesh.triangles[i];
    if (t[0] >= mesh.numVertices || t[1] >= mesh.numVertices || t[2] >= mesh.numVertices) {
      report.invalidTriangles++;
      return;
    }
    const float *const a = mesh.vertices[t[0]], *const b = mesh.vertices[t[1]], *const c = mesh.vertices[t[2]];
    if (!isFinite(a) || !isFinite(b) || !isFinite(c)) {
      report.invalidTriangles++;
      return;
    }
    if (!lattice.isRobust(a, b, c)) {
      if (MeshLattice::isDegenerate(a, b, c)) {
        report.degenerateTriangles++;
        return;
      }
      hasFlat |= MeshLattice::isFlat(a, b, c);
      lattice.refine(a, b, c);
    }
    float lower[3], upper[3];
    bounds(mesh, i, lower, upper);
    centers.push_back(
        {{0.5f * (lower[0] + upper[0]), 0.5f * (lower[1] + upper[1]), 0.5f * (lower[2] + upper[2])}, uint32_t(i)});
  }

  static void bounds(const MeshSource& mesh, size_t i, float lower[3], float upper[3]) {
    const uint32_t* const t = mesh.triangles[i];
    const float *const a = mesh.vertices[t[0]], *const b = mesh.vertices[t[1]], *const c = mesh.vertices[t[2]];
    for (int k = 0; k < 3; k++) {
      lower[k] = std::min(std::min(a[k], b[k]), c[k]);
      upper[k] = std::max(std::max(a[k], b[k]), c[k]);
    }
  }

  /*! Assigns vertices to finer lattices until snapping flips no triangle. Repeats, because a vertex that moves may
   *  flip its other triangles. */
  void refineUntilNoneFlips(const MeshSource& mesh, const std::vector<MeshCenter>& centers) {
    for (bool changed = true; changed;) {
      changed = false;
      for (const MeshCenter& center : centers) {
        const uint32_t* const t = mesh.triangles[center.index];
        changed |= lattice.refine(mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]);
      }
    }
  }

  /*! Omits flat triangles if snapping made two of their corners equal. */
  void removeCollapsed(const MeshSource& mesh, std::vector<MeshCenter>& centers, MeshReport& report) {
    size_t count = 0;
    for (const MeshCenter& center : centers) {
      float corners[3][3];
      for (int c = 0; c < 3; c++) lattice.snap(mesh.vertices[mesh.triangles[center.index][c]], corners[c]);
      if (MeshLattice::isDegenerate(corners[0], corners[1], corners[2])) report.degenerateTriangles++;
      else centers[count++] = center;
    }
    centers.resize(count);
  }

  template<typename OnBlock>
  void encodeCluster(const MeshSource& mesh, const MeshCenter* cluster, const MeshGroups& groups,
                     MeshStatistics& statistics, const OnBlock& onBlock) {
    for (uint32_t i = 0; i < groups.numTriangles(); i++) {
      const uint32_t index = cluster[i].index;
      for (int c = 0; c < 3; c++) lattice.snap(mesh.vertices[mesh.triangles[index][c]], triangles[i].corners[c]);
      triangles[i].number = index;
    }
    encoder->encodeCluster(triangles, groups, false, settings.surface, block, statistics,
                           [&](size_t, uint32_t, uint32_t) { onBlock((const MeshHeader*)block); });
  }

  const MeshSettings settings;
  MeshLattice lattice;
  bool hasFlat = false; //!< a triangle's corners are on a line
  const std::unique_ptr<MeshEncoder> encoder;
  MeshTriangle triangles[maxMeshTriangles];
  alignas(16) uint8_t block[MeshEncoder::maxBytes];
};
}} // namespace cvert::CVERT_ISA
