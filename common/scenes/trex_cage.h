// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The control cage of `trex`: a body from an implicit surface, and closed pieces that intersect it. One unit is
 * about a meter; x points from tail to head, y up, z to its right. */

#include "surface/cage.h"

#include <cstdint>
#include <vector>

namespace programs {

enum class TrexPart : uint8_t { Skin, Tooth, Claw, Eye, Lid, Tongue };

struct TrexCage {
  Cage cage;
  std::vector<TrexPart> parts;
};

TrexCage makeTrexCage();

/* The right eye; the left one is its mirror image in z. */
constexpr Vec3f trexEye{3.95f, 5.15f, 0.4f};
constexpr float trexEyeRadius = 0.12f;

} // namespace programs
