// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Finds vertices at which Embree and OpenSubdiv subdivide creases differently:
 *
 * - Three or more creases meet, and one other than the two sharpest has a fractional sharpness. OpenSubdiv blends the
 *   corner with what remains after that crease ends, by the fraction (DeRose, Kass and Truong 1998). Embree keeps the
 *   corner for the whole step: a third crease of 0.0001 makes a spike, no third crease makes a curve.
 * - Two creases of different sharpness meet. Embree averages their sharpness in each step; OpenSubdiv does so only
 *   if a tag selects Chaikin's rule.
 * - A semi-sharp corner lies on creases. OpenSubdiv blends it with the crease, Embree with the smooth surface. */

#include "surface/cage.h"

#include <vector>

namespace programs {

/* The cage must be valid. Under Chaikin's rule, includes every vertex at which three or more creases of different
 * sharpness meet. */
std::vector<unsigned> findVerticesWithDifferentCreaseRules(const Cage& cage);

} // namespace programs
