// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* OpenSubdiv checks a cage before Embree receives it: Embree silently leaves out faces or tears the surface. */

#include "surface/cage.h"

#include <string>

namespace cbvh {

/* Turns faces beyond Embree's limits (16 vertices per face, 64 faces around a vertex) into holes.
 *
 * Appends one line to `warnings` for each kind of:
 * - faces beyond these limits,
 * - edges that are not manifold: more than two faces, or two of opposite orientation. Embree leaves their vertices in
 *   place or makes a hard crease,
 * - vertices that join parts without a common edge,
 * - vertices at which Embree and OpenSubdiv have different crease rules.
 *
 * Throws Error with the cage's name if OpenSubdiv rejects the topology or a face contains a vertex twice. */
void validateCage(Cage& cage, std::string& warnings);

} // namespace cbvh
