// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A creature in the manner of a Tyrannosaurus: a closed organic cage of about 7,000
 * quads with thousands of extraordinary vertices, and a skin of layered scales and
 * wrinkles from a float EXR map.
 *
 * The map is generated, written, and read back like any other. It is an atlas of one
 * tile a face. Heights are a function of the limit position, and border texels lie
 * on the borders of the faces: faces agree on their common edge. */

#include "../model.h"

#include <string>

namespace cbvh {

struct TrexSettings
{
  float amplitude = 0.004f;  // of the diagonal of the cage's bounding box, from 0 to 1 in the map
  std::string mapPath;       // where the height map is written, as EXR
  int threads = 0;           // for generating it, 0 for all
};

/* The rough variant of the skin. */
constexpr float trexRoughFactor = 5.0f;

/* The cage alone. */
Cage makeTrexCage();

/* Throws Error when the map cannot be written, Cancelled. Shows progress. */
Model makeTrex(const TrexSettings& settings);

} // namespace cbvh
