// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What there is to say of a surface that was built. Plain data: the library's parts of all instruction sets share it. */

#include "../../../include/embree3/rtcore_compression.h"
#include <algorithm>
#include <cstddef>
#include <limits>

namespace embree
{
  namespace cbvh
  {
    inline void add (RTCCompressionStatistics& sums, const RTCCompressionStatistics& other)
    {
      sums.topLevelBytes += other.topLevelBytes;
      sums.frameBytes += other.frameBytes;
      sums.nodeBytes += other.nodeBytes;
      sums.leafBytes += other.leafBytes;
      sums.gridBytes += other.gridBytes;
      sums.numBlocks += other.numBlocks;
      sums.numQuads += other.numQuads;
      sums.numGridQuads += other.numGridQuads;
      sums.numInvalidQuads += other.numInvalidQuads;
      sums.numAffineBlocks += other.numAffineBlocks;
      sums.numSolidLeaves += other.numSolidLeaves;
      sums.numRawBlocks += other.numRawBlocks;
      sums.numExactQuads += other.numExactQuads;
      sums.numFlippedQuads += other.numFlippedQuads;
      sums.numMeshQuads += other.numMeshQuads;
      sums.numLooseQuads += other.numLooseQuads;
      sums.numMovingQuads += other.numMovingQuads;
      sums.motionBytes += other.motionBytes;
      sums.numUnsupportedFaces += other.numUnsupportedFaces;
      sums.inputBytes += other.inputBytes;
      sums.maxVertexSpacing = std::max(sums.maxVertexSpacing,other.maxVertexSpacing);
      sums.maxVertexDeviation = std::max(sums.maxVertexDeviation,other.maxVertexDeviation);
      sums.maxBorderGap = std::max(sums.maxBorderGap,other.maxBorderGap);
      sums.maxLeafThickness = std::max(sums.maxLeafThickness,other.maxLeafThickness);
    }

    struct SurfaceStatistics
    {
      RTCCompressionStatistics sums = RTCCompressionStatistics();
      size_t highRateQuads = 0;    //!< traced by GRID for their edge rates
      size_t refusedQuads = 0;     //!< at full precision as their block has no good frame
      size_t refusedInGrid = 0;    //!< those of them that GRID traces
      size_t quadsForHoles = 0;    //!< of patches that holes make another kind, as theirs cannot leave a quad out
      size_t invalidFaces = 0;     //!< with quads that are left out
      size_t bytesInEmbree = 0;    //!< that Embree's own kernels would use, about
      size_t firstInvalidFace = std::numeric_limits<size_t>::max();
      size_t firstUnsupportedFace = std::numeric_limits<size_t>::max();
    };
  }
}
