// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A creature in the manner of a Tyrannosaurus: a closed organic cage of about 7,000
 * quads with thousands of extraordinary vertices, teeth, claws and eyes, and a skin of
 * layered scales and wrinkles from a float EXR map of more than 4096 x 4096.
 *
 * The map is generated, written, and read back like any other; a map that is there
 * already and was made for this cage is taken as it is. Heights are a function of the
 * limit position, so faces agree on their common edges. */

#include "surface/model.h"

#include <string>

namespace cbvh {

enum class TrexMapping
{
  Faces, // like Ptex: a tile a face, no texture coordinates
  Atlas, // charts of many faces, through texture coordinates
};

constexpr float trexAmplitude = 0.004f;

struct TrexSettings
{
  float amplitude = trexAmplitude; // of the diagonal of the cage's bounding box, from 0 to 1 in the map
  TrexMapping mapping = TrexMapping::Faces;
  std::string mapFolder;     // where the height map is kept, as EXR
  int threads = 0;           // for generating it, 0 for all
};

/* The rough variant of the skin. */
constexpr float trexRoughFactor = 5.0f;

/* Throws Error when the map cannot be written or read, Cancelled. Shows progress. */
Model makeTrex(const TrexSettings& settings);

} // namespace cbvh
