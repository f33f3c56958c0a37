// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Where Embree subdivides creases by another rule than OpenSubdiv, whose tags cages have.
 *
 *   - Three and more creases meet, and one of them is sharp by a fraction. OpenSubdiv blends
 *     the corner with what is left when that crease is gone, by the fraction. Embree keeps the
 *     corner for the whole step: a third crease of 0.0001 makes a spike where none makes a
 *     curve. OpenSubdiv's is the rule of DeRose, Kass and Truong 1998, and of Pixar's older
 *     library Hbr, and it is continuous in the sharpness.
 *   - Two creases that are not equally sharp. Embree mixes their sharpness from step to step,
 *     as Chaikin's rule does. OpenSubdiv does so where a tag asks for it.
 *   - A semi-sharp corner on creases. OpenSubdiv blends it with the crease, Embree with the
 *     smooth surface. */

#include "surface/cage.h"

#include <vector>

namespace cbvh {

/* Vertices of a cage that is valid. Where three and more creases of different sharpness meet
 * under Chaikin's rule, all are named. */
std::vector<unsigned> verticesOfOtherCreaseRules(const Cage& cage);

} // namespace cbvh
