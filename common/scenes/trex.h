// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A creature similar to a Tyrannosaurus: a closed organic cage of about 7,000 quads with thousands of extraordinary
 * vertices, teeth, claws and eyes, and a skin of layered scales and wrinkles from a float EXR map of more than
 * 4096 x 4096 texels.
 *
 * The map is generated, written, and read like any other map. An existing map is reused if it was made for this cage.
 * Heights are a function of the limit position, so faces agree on their common edges. */

#include "surface/model.h"

#include <string>

namespace cbvh {

enum class TrexMapping
{
  Faces, // as in Ptex: one tile per face, no texture coordinates
  Atlas, // charts of many faces, through texture coordinates
};

constexpr float trexAmplitude = 0.004f;

struct TrexSettings
{
  float amplitude = trexAmplitude; // displacement between heights 0 and 1 as a fraction of the cage's diagonal
  TrexMapping mapping = TrexMapping::Faces;
  std::string mapFolder; // folder of the height map, an EXR
  int threads = 0;       // for generating the map, 0 for all
};

/* Factor of the amplitude of the rough variant. */
constexpr float trexRoughFactor = 5.0f;

/* Shows progress. Throws Error if the map cannot be written or read. Throws Canceled. */
Model makeTrex(const TrexSettings& settings);

} // namespace cbvh
