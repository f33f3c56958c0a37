// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Sums of what a build compressed. Build tasks fill one each and merge them. */

#include "block_encoder.h"
#include "../../include/embree3/rtcore_compression.h"

namespace embree
{
  namespace cbvh
  {
    struct BuildStatistics : public RTCCompressionStatistics
    {
      BuildStatistics () : RTCCompressionStatistics() {}

      void addBlock (Kind kind, uint32_t height, const BlockStatistics& block)
      {
        const BlockLayout layout(kind,height);
        frameBytes += layout.nodeOffset;
        nodeBytes += layout.leafOffset - layout.nodeOffset;
        leafBytes += layout.stride() - layout.leafOffset;
        numBlocks++;
        numQuads += size_t(1) << (2*height);
        numInvalidQuads += block.invalidQuads;
        numAffineBlocks += block.affine;
        numSolidLeaves += block.solidLeaves;
        if (block.maxThickness > maxLeafThickness) maxLeafThickness = block.maxThickness;
      }

      void merge (const BuildStatistics& other)
      {
        topLevelBytes += other.topLevelBytes;
        frameBytes += other.frameBytes;
        nodeBytes += other.nodeBytes;
        leafBytes += other.leafBytes;
        gridBytes += other.gridBytes;
        numBlocks += other.numBlocks;
        numQuads += other.numQuads;
        numGridQuads += other.numGridQuads;
        numInvalidQuads += other.numInvalidQuads;
        numAffineBlocks += other.numAffineBlocks;
        numSolidLeaves += other.numSolidLeaves;
        if (other.maxLeafThickness > maxLeafThickness) maxLeafThickness = other.maxLeafThickness;
      }
    };
  }
}
