// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Closed pieces of all-quad cages: balls, and tubes for limbs, horns, teeth and blades. */

#include "surface/cage.h"

#include <vector>

namespace programs {

/* Cross-section of a tube: an ellipse with half axes a and b, counterclockwise as seen from the next station. */
struct Station {
  Vec3f center, a, b;
};

/* Appends a closed tube of at least two stations. `sides` is 4 or 8. The limit surface is slightly inside the
 * ellipses. */
void appendTube(Cage& cage, const std::vector<Station>& stations, int sides);

/* Tapers to a point and bends towards a direction. `bend` is the tip's distance from the straight line, in lengths;
 * `flatness` is the width across the plane of the bend divided by the width in it. */
struct Horn {
  Vec3f base, direction, bendTowards;
  float length, radius;
  float bend = 0.0f, flatness = 1.0f;
  int stations = 4;
};
void appendHorn(Cage& cage, const Horn& horn);

/* A cube with steps x steps quads per side, made round. */
void appendBall(Cage& cage, Vec3f center, float radius, int steps);

} // namespace programs
