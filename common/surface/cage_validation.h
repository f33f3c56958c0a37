// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks a cage with OpenSubdiv before Embree receives it. Embree accepts an invalid cage silently and leaves out
 * faces or tears the surface. */

#include "surface/cage.h"

#include <string>

namespace cbvh {

/* Turns faces beyond Embree's limits (16 vertices per face, 64 faces around a vertex) into holes.
 *
 * Appends to `warnings` one line for each kind of:
 *   - faces beyond these limits;
 *   - edges that are not manifold: with more than two faces, or with two of opposite orientation. Embree leaves their
 *     vertices in place, or makes a hard crease;
 *   - vertices that join parts without a common edge;
 *   - vertices at which Embree and OpenSubdiv have different crease rules.
 * Throws Error, one line that starts with the cage's name, if OpenSubdiv rejects the topology or if a face contains a
 * vertex twice. */
void validateCage(Cage& cage, std::string& warnings);

} // namespace cbvh
