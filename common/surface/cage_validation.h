// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks a cage with OpenSubdiv before Embree gets it. Embree itself takes a bad
 * cage in silence and leaves faces out or tears the surface. */

#include "surface/cage.h"

namespace cbvh {

/* Throws Error, one line that starts with the cage's name, for: whatever
 * OpenSubdiv's topology validation reports, a face that names a vertex twice, an
 * edge of more than two faces or run through twice in the same direction, and what
 * is beyond Embree's limits (16 vertices a face, 64 faces around a vertex). */
void validateCage(const Cage& cage);

} // namespace cbvh
