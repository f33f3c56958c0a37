// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Sums of what a build compressed. Every task fills one and merges it. */

#include "block_encoder.h"
#include "../../../include/embree3/rtcore_compression.h"
#include <algorithm>
#include <limits>

namespace embree
{
  namespace cbvh { inline namespace CBVH_ISA
  {
    struct BuildStatistics
    {
      RTCCompressionStatistics sums = RTCCompressionStatistics();
      size_t highRateQuads = 0;    //!< traced by GRID for their edge rates
      size_t refusedQuads = 0;     //!< at full precision as their block has no good frame
      size_t quadsForHoles = 0;        //!< of patches that holes make another kind, as theirs cannot leave a quad out
      size_t invalidFaces = 0;     //!< with quads that are left out
      size_t firstInvalidFace = std::numeric_limits<size_t>::max();

      void addInvalidFace (size_t face)
      {
        invalidFaces++;
        firstInvalidFace = std::min(firstInvalidFace,face);
      }

      void addBlock (Kind kind, uint32_t height, const BlockStatistics& block)
      {
        const BlockLayout layout = blockLayout(uint32_t(kind),height);
        sums.frameBytes += blockHeaderBytes;
        sums.nodeBytes += layout.leafOffset - blockHeaderBytes;
        sums.leafBytes += layout.stride - layout.leafOffset;
        sums.numBlocks++;
        sums.numQuads += size_t(1) << (2*height);
        sums.numInvalidQuads += block.invalidQuads;
        sums.numAffineBlocks += block.affine;
        sums.numSolidLeaves += block.solidLeaves;
        if (block.maxThickness > sums.maxLeafThickness) sums.maxLeafThickness = block.maxThickness;
      }

      void merge (const BuildStatistics& other)
      {
        sums.topLevelBytes += other.sums.topLevelBytes;
        sums.frameBytes += other.sums.frameBytes;
        sums.nodeBytes += other.sums.nodeBytes;
        sums.leafBytes += other.sums.leafBytes;
        sums.gridBytes += other.sums.gridBytes;
        sums.numBlocks += other.sums.numBlocks;
        sums.numQuads += other.sums.numQuads;
        sums.numGridQuads += other.sums.numGridQuads;
        sums.numInvalidQuads += other.sums.numInvalidQuads;
        sums.numAffineBlocks += other.sums.numAffineBlocks;
        sums.numSolidLeaves += other.sums.numSolidLeaves;
        if (other.sums.maxLeafThickness > sums.maxLeafThickness) sums.maxLeafThickness = other.sums.maxLeafThickness;
        highRateQuads += other.highRateQuads;
        refusedQuads += other.refusedQuads;
        quadsForHoles += other.quadsForHoles;
        invalidFaces += other.invalidFaces;
        firstInvalidFace = std::min(firstInvalidFace,other.firstInvalidFace);
      }
    };
  }}
}
