// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "stored_clusters.h"
#include "../embree/scene.h"
#include "../../cvert/clusters/compressed1.h"
#include "../../cvert/clusters/dgf_tiling.h"
#include "surface_blocks.h"
#include <algorithm>
#include <memory>

namespace embree::cbvh {
namespace {
/*! Why clusters of a block may need floats. */
ClusterReason reasonForFloatsOf(const StoredBlock& block) {
  const BlockRow row = rowOf(block.type);
  if (row.moves(block.data)) return ClusterReason::MOVING;
  return row.hasFloats(block.data) ? ClusterReason::FLOATS : ClusterReason::OUT_OF_RANGE;
}

class ClusterBuilder {
public:
  ClusterBuilder(ClusterFormat format, const std::function<bool(const StoredCluster&)>& closure,
                 ClusterStatistics& statistics)
    : format(format),
      closure(closure),
      statistics(statistics) {}

  /*! Divides a part into clusters. Returns false if the closure returned false. */
  bool build(const StoredBlock& block, const StoredPart& part) {
    this->part = &part;
    reasonForFloats = reasonForFloatsOf(block);
    const QuadRectangle all = {0, 0, part.width - 1, part.height - 1};
    if (format == ClusterFormat::DGF1) {
      bool shouldContinue = true;
      if (tileWithDgf(all, shouldContinue)) return shouldContinue;
      return forEachSquare(all, [&](const QuadRectangle& square) {
        return tileWithDgf(square, shouldContinue) ? shouldContinue : emitFloats(square, reasonForFloats);
      });
    }
    return forEachSquare(all, [&](const QuadRectangle& square) { return emitVertices(square); });
  }

private:
  /*! Calls closure for squares of up to 8 x 8 quads, until it returns false. */
  template<typename Closure>
  static bool forEachSquare(const QuadRectangle& rect, const Closure& closure) {
    const uint32_t side = QuadTriangles::maxQuadsPerSide;
    for (uint32_t y = 0; y < rect.height; y += side)
      for (uint32_t x = 0; x < rect.width; x += side) {
        const QuadRectangle square = {rect.x + x, rect.y + y, std::min(side, rect.width - x),
                                      std::min(side, rect.height - y)};
        if (!closure(square)) return false;
      }
    return true;
  }

  /*! Finds the lattice of a rectangle's vertices. Returns false if their positions fit no lattice. */
  bool findLattice(LatticePoints& points, const QuadRectangle& rect) const {
    return points.set(part->vertices + 3 * (size_t(rect.y) * part->width + rect.x), part->width, rect.width + 1,
                      rect.height + 1);
  }

  /*! Emits a square in COMPRESSED1 if it was requested and is possible, otherwise as floats. */
  bool emitVertices(const QuadRectangle& square) {
    if (format == ClusterFormat::FLOAT3) return emitFloats(square, ClusterReason::NONE);
    const QuadTriangles triangles(part->vertices, part->width, square, false);
    if (triangles.numTriangles == 0) return true;
    LatticeSpan span;
    if (findLattice(points, square))
      for (uint32_t i = 0; i < triangles.numVertices; i++) span.add(points.at[triangles.vertices[i]]);
    if (span.isEmpty() || !span.fits()) return emitFloats(square, reasonForFloats);
    std::fill_n(data, sizeof(data) / sizeof(data[0]), 0u);
    const size_t bytes = writeCompressed1(points, span, triangles.vertices, triangles.numVertices, (uint8_t*)data);
    return emit(square, triangles, ClusterFormat::COMPRESSED1, ClusterReason::NONE, bytes);
  }

  bool emitFloats(const QuadRectangle& square, ClusterReason reason) {
    const QuadTriangles triangles(part->vertices, part->width, square, false);
    if (triangles.numTriangles == 0) return true;
    for (uint32_t i = 0; i < triangles.numVertices; i++) {
      const uint32_t v = triangles.vertices[i], x = v % (square.width + 1), y = v / (square.width + 1);
      memcpy(data + 3 * i, part->vertices + 3 * (size_t(square.y + y) * part->width + square.x + x), 12);
    }
    return emit(square, triangles, ClusterFormat::FLOAT3, reason, 12 * triangles.numVertices);
  }

  /*! Tiles a rectangle with blocks of DGF. shouldContinue: set to the result of the last closure. Returns false,
   *  without calling the closure, if the rectangle has more than 16 quads on a side, its vertices fit no lattice,
   *  or a quad does not fit into a block of DGF. */
  bool tileWithDgf(const QuadRectangle& rect, bool& shouldContinue) {
    if (rect.width >= LatticePoints::maxSide || rect.height >= LatticePoints::maxSide || !findLattice(points, rect))
      return false;
    const dgf::Tiling tiling(points, rect.width, rect.height);
    if (!tiling.isPossible) return false;
    tiling.forEach([&](uint32_t x, uint32_t y, uint32_t width, uint32_t height) {
      const QuadRectangle piece = {rect.x + x, rect.y + y, width, height};
      if (shouldContinue) shouldContinue = emitDgf(rect, piece);
    });
    return true;
  }

  /*! Emits a piece of `rect`, whose vertices are in `points`. */
  bool emitDgf(const QuadRectangle& rect, const QuadRectangle& piece) {
    QuadTriangles triangles(part->vertices, part->width, piece, true);
    if (triangles.numTriangles == 0) return true;
    for (uint32_t i = 0; i < triangles.numVertices; i++) {
      const uint32_t v = triangles.vertices[i], x = v % (piece.width + 1), y = v / (piece.width + 1);
      triangles.vertices[i] = (piece.y - rect.y + y) * points.width + piece.x - rect.x + x;
    }
    if (statistics.numTriangles + triangles.numTriangles > dgf::maxPrimitives)
      throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the geometry has too many triangles for DGF: expected at most "
                                                  "2^29, because primitive indices of DGF have 29 bits");
    if (!block.write(triangles, points, uint32_t(statistics.numTriangles))) {
      /* The tiling assumes that no triangle is missing. Otherwise the piece may need more strips of triangles
       * than fit: halve it. */
      QuadRectangle halves[2] = {piece, piece};
      if (piece.width >= piece.height) {
        halves[0].width /= 2;
        halves[1].x += halves[0].width;
        halves[1].width -= halves[0].width;
      } else {
        halves[0].height /= 2;
        halves[1].y += halves[0].height;
        halves[1].height -= halves[0].height;
      }
      return emitDgf(rect, halves[0]) && emitDgf(rect, halves[1]);
    }
    triangles.isComplete = false;
    triangles.numVertices = block.numVertices;
    memcpy(triangles.indices, block.indices, 3 * triangles.numTriangles);
    memcpy(data, block.bytes, sizeof(block.bytes));
    return emit(piece, triangles, ClusterFormat::DGF1, ClusterReason::NONE, sizeof(block.bytes));
  }

  bool emit(const QuadRectangle& square, const QuadTriangles& triangles, ClusterFormat format, ClusterReason reason,
            size_t bytes) {
    if (uint64_t(statistics.numTriangles) + triangles.numTriangles > uint64_t(1) << 32)
      throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the geometry has too many triangles for clusters: expected at "
                                                  "most 2^32, because firstTriangle has 32 bits");
    StoredCluster cluster = StoredCluster();
    cluster.format = format;
    cluster.reason = reason;
    cluster.numVertices = triangles.numVertices;
    cluster.numTriangles = triangles.numTriangles;
    cluster.data = data;
    cluster.bytes = bytes;
    cluster.indices = triangles.indices[0];
    cluster.triangleNumbers = triangles.triangles;
    cluster.firstTriangle = unsigned(statistics.numTriangles);
    if (triangles.isComplete) {
      cluster.width = square.width + 1;
      cluster.height = square.height + 1;
    }
    cluster.part = part;
    statistics.numClusters++;
    statistics.numTriangles += cluster.numTriangles;
    statistics.numVertices += cluster.numVertices;
    statistics.bytes += bytes;
    if (!triangles.isComplete && format != ClusterFormat::DGF1) statistics.indexBytes += 3 * cluster.numTriangles;
    statistics.numClustersByReason[int(reason)]++;
    statistics.numTrianglesByReason[int(reason)] += cluster.numTriangles;
    return closure(cluster);
  }

  const ClusterFormat format;
  const std::function<bool(const StoredCluster&)>& closure;
  ClusterStatistics& statistics;
  const StoredPart* part = nullptr;
  ClusterReason reasonForFloats = ClusterReason::NONE; //!< why clusters of this block may need floats
  LatticePoints points;
  dgf::Block block;
  uint32_t data[3 * QuadTriangles::maxVertices];
};

static_assert(maxCompressed1Bytes(QuadTriangles::maxVertices) <= 12 * QuadTriangles::maxVertices,
              "COMPRESSED1 needs no more room than floats");
} // namespace

void forEachCluster(const SurfaceBlocks& blocks, const TraversalTime& time, ClusterFormat format,
                    const std::function<bool(const StoredCluster&)>& closure, ClusterStatistics& statistics) {
  const std::unique_ptr<ClusterBuilder> builder(new ClusterBuilder(format, closure, statistics));
  forEachPart(blocks, time,
              [&](const StoredBlock& block, const StoredPart& part) { return builder->build(block, part); });
}
} // namespace embree::cbvh
