// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Heights from 0 to 1. */

#include "scenes/trex_cage.h"

namespace programs {

/* Increment when trexHeight changes: the cached map's recipe contains it. */
constexpr int trexSkinVersion = 2;

/* `p` is on the limit surface. */
float trexHeight(TrexPart part, Vec3f p);

} // namespace programs
