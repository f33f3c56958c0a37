// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/built_scene.h"

#include <nlohmann/json.hpp>

namespace programs {

inline nlohmann::json compressionJson(const RTCCompressionStatistics& s) {
  return {{"top_level_bytes", s.topLevelBytes},
          {"header_bytes", s.headerBytes},
          {"node_bytes", s.nodeBytes},
          {"leaf_bytes", s.leafBytes},
          {"uncompressed_bytes", s.uncompressedBytes},
          {"blocks", s.numBlocks},
          {"quads", s.numQuads},
          {"uncompressed_quads", s.numUncompressedQuads},
          {"invalid_quads", s.numInvalidQuads},
          {"affine_blocks", s.numAffineBlocks},
          {"solid_leaves", s.numSolidLeaves},
          {"max_leaf_thickness", s.maxLeafThickness},
          {"raw_blocks", s.numRawBlocks},
          {"max_vertex_spacing", s.maxVertexSpacing},
          {"max_border_mismatch", s.maxBorderMismatch},
          {"max_vertex_deviation", s.maxVertexDeviation},
          {"fallback_quads", s.numFallbackQuads},
          {"fallback_quads_share", fallbackQuadFraction(s)},
          {"flipped_quads", s.numFlippedQuads}};
}

} // namespace programs
