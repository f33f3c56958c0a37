// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks a cage with OpenSubdiv before Embree gets it. Embree itself takes a bad
 * cage in silence and leaves faces out or tears the surface. */

#include "surface/cage.h"

#include <string>

namespace cbvh {

/* Faces beyond Embree's limits (16 vertices a face, 64 faces around a vertex) become holes.
 *
 * warnings: lines are added on such faces, and on edges at which the cage is not manifold:
 * of more than two faces, or run through twice in the same direction; there Embree keeps the
 * vertices where they are, or makes a hard crease. And on vertices that join parts without an
 * edge in common, and those where Embree has another rule for creases than OpenSubdiv.
 * Errors: throws Error, one line that starts with the cage's name, for whatever OpenSubdiv's
 * topology validation reports, and a face that names a vertex twice. */
void validateCage(Cage& cage, std::string& warnings);

} // namespace cbvh
