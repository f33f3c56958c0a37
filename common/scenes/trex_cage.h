// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The control cage of `trex`: a body out of an implicit surface, with teeth, claws,
 * eyes, lids and tongue as closed pieces that stand in it. One unit is about a metre; x
 * runs from tail to head, y up, the left side is +z. */

#include "surface/cage.h"

#include <cstdint>
#include <vector>

namespace cbvh {

enum class TrexPart : uint8_t { Skin, Tooth, Claw, Eye, Lid, Tongue };

struct TrexCage
{
  Cage cage;
  std::vector<TrexPart> parts; // a face each
};

TrexCage makeTrexCage();

/* Middle of the left eyeball; the right one mirrors it in z. */
constexpr Vec3f trexEye{3.95f, 5.15f, 0.4f};
constexpr float trexEyeRadius = 0.12f;

} // namespace cbvh
