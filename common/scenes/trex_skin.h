// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The skin of `trex` as heights within 0 and 1. */

#include "scenes/trex_cage.h"

namespace cbvh {

/* Changes with what the functions below return. */
constexpr int trexSkinVersion = 2;

/* Height of a part at a point of the limit surface. */
float trexHeight(TrexPart part, Vec3f p);

} // namespace cbvh
