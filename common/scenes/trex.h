// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Similar to a Tyrannosaurus: a closed cage of about 7,900 quads with thousands of extraordinary vertices, and a skin
 * of scales and wrinkles from a float EXR map of more than 4096 x 4096 texels.
 *
 * The map is generated, written, and read like any other map; it is reused if it was generated for this cage. Heights
 * depend on the limit position only, so faces agree on common edges. */

#include "surface/model.h"

#include <string>

namespace programs {

enum class TrexMapping {
  Faces, // as in Ptex, without texture coordinates
  Atlas, // charts of many faces, through texture coordinates
};

constexpr float trexAmplitude = 0.004f;

struct TrexSettings {
  float amplitude = trexAmplitude; // displacement between heights 0 and 1 as a fraction of the cage's diagonal
  TrexMapping mapping = TrexMapping::Faces;
  std::string mapFolder; // of the height map, an EXR
  int threads = 0;       // 0 for all
};

/* Factor of the amplitude. */
constexpr float trexRoughFactor = 5.0f;

/* Shows progress. Throws Error if the map cannot be written or read. */
Model makeTrex(const TrexSettings& settings);

} // namespace programs
