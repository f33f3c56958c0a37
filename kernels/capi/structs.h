// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Structs of cbvh.h: those that may grow, and conversion from and to types of the kernels. */

#include "cbvh/cbvh.h"

#include "cbvh/operations/struct_size.h"
#include "cbvh/base/surface_statistics.h"
#include "cbvh/blocks/cluster.h"
#include "cbvh/surface/dicing_camera.h"

#include <cstring>

namespace embree {
namespace core {

/* The member is the last one of the struct's first version, see operations/struct_size.h. */
CBVH_EXTENSIBLE_STRUCT(CbvhCage, attributes);
CBVH_EXTENSIBLE_STRUCT(CbvhGrids, vertices);
CBVH_EXTENSIBLE_STRUCT(CbvhMesh, vertices);
CBVH_EXTENSIBLE_STRUCT(CbvhDicingArguments, maxRates);
CBVH_EXTENSIBLE_STRUCT(CbvhAccuracy, pixelSize);
CBVH_EXTENSIBLE_STRUCT(CbvhInterpolationPoints, dPdv);
CBVH_EXTENSIBLE_STRUCT(CbvhGroupStatistics, maxVertexDeviation);
CBVH_EXTENSIBLE_STRUCT(CbvhQuery, filterUserPtr);
CBVH_EXTENSIBLE_STRUCT(CbvhPointQuery, userPtr);
CBVH_EXTENSIBLE_STRUCT(CbvhClusterStatistics, numTrianglesByReason);
CBVH_EXTENSIBLE_STRUCT(CbvhFileSurfaceInfo, bytes);
CBVH_EXTENSIBLE_STRUCT(CbvhSurfaceStatistics, maxBorderMismatch);

} // namespace core

namespace capi {

inline DicingCamera cameraOf(const CbvhDicingArguments& dicing) {
  const DicingCamera defaults;
  DicingCamera camera = dicingCamera(dicing);
  if (camera.quadSize == 0) camera.quadSize = defaults.quadSize;
  if (camera.outsideFactor == 0) camera.outsideFactor = defaults.outsideFactor;
  if (camera.maxRate == 0) camera.maxRate = defaults.maxRate;
  return camera;
}

inline CbvhTriangle toPublic(const cbvh::StoredTriangle& triangle) {
  CbvhTriangle to;
  static_assert(sizeof(to) == sizeof(triangle), "CbvhTriangle must have the layout of StoredTriangle");
  std::memcpy(&to, &triangle, sizeof(to));
  return to;
}

inline CbvhPart toPublic(const cbvh::StoredPart& part) {
  return {part.primID, part.width, part.height, part.vertices, part.parameters, part.primIDs, part.primitivesPerQuad};
}

inline CbvhSurfaceStatistics toPublic(const cbvh::CompressionStatistics& from) {
  CbvhSurfaceStatistics to;
  to.topLevelBytes = from.topLevelBytes;
  to.headerBytes = from.headerBytes;
  to.nodeBytes = from.nodeBytes;
  to.leafBytes = from.leafBytes;
  to.motionBytes = from.motionBytes;
  to.numBlocks = from.numBlocks;
  to.numRawBlocks = from.numRawBlocks;
  to.numAffineBlocks = from.numAffineBlocks;
  to.numSolidLeaves = from.numSolidLeaves;
  to.numQuads = from.numQuads;
  to.numInvalidQuads = from.numInvalidQuads;
  to.numFallbackQuads = from.numFallbackQuads;
  to.numFlippedQuads = from.numFlippedQuads;
  to.numMeshQuads = from.numMeshQuads;
  to.numIrregularQuads = from.numIrregularQuads;
  to.numMovingQuads = from.numMovingQuads;
  to.maxLeafThickness = from.maxLeafThickness;
  to.maxVertexSpacing = from.maxVertexSpacing;
  to.maxVertexDeviation = from.maxVertexDeviation;
  to.maxBorderMismatch = from.maxBorderMismatch;
  return to;
}

static_assert(CBVH_CLUSTER_FORMAT_COMPRESSED1 == int(cbvh::ClusterFormat::COMPRESSED1) &&
                  CBVH_CLUSTER_FORMAT_DGF1 == int(cbvh::ClusterFormat::DGF1),
              "values of CbvhClusterFormat");
static_assert(CBVH_CLUSTER_REASON_FLOATS == int(cbvh::ClusterReason::FLOATS) &&
                  CBVH_CLUSTER_REASON_MOVING == int(cbvh::ClusterReason::MOVING) &&
                  CBVH_CLUSTER_REASON_OUT_OF_RANGE == int(cbvh::ClusterReason::OUT_OF_RANGE),
              "values of CbvhClusterReason");

} // namespace capi
} // namespace embree
