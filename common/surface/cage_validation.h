// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* OpenSubdiv checks a cage before Embree receives it: Embree silently leaves out faces or tears the surface. */

#include "surface/cage.h"

#include <string>

namespace programs {

/* Turns faces beyond Embree's limits (16 vertices per face, 1024 faces around a vertex) into holes.
 *
 * Appends a line to `warnings` for each face and each vertex beyond these limits, if all vertices have the same
 * position, and for each kind of:
 * - edges that are not manifold: more than two faces, or two of opposite orientation. Embree leaves their vertices in
 *   place or makes a hard crease,
 * - vertices that join parts without a common edge,
 * - vertices at which Embree and OpenSubdiv have different crease rules,
 * - holes, unless their borders are infinitely sharp, and faces that only Embree leaves out under BoundaryRule::None.
 *
 * Throws Error with the cage's name if OpenSubdiv rejects the topology, a face contains a vertex twice, or no face is
 * left. */
void validateCage(Cage& cage, std::string& warnings);

} // namespace programs
