// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The skin of `trex` as heights from 0 to 1. */

#include "scenes/trex_cage.h"

namespace cbvh {

/* Must be incremented when trexHeight changes, because it is a part of the cached map's recipe. */
constexpr int trexSkinVersion = 2;

/* Returns the height of a part at a point of the limit surface. */
float trexHeight(TrexPart part, Vec3f p);

} // namespace cbvh
