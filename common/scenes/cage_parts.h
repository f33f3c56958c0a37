// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Closed pieces of all-quad cages: balls, and tubes along a curve for limbs, horns, teeth and blades. */

#include "surface/cage.h"

#include <vector>

namespace cbvh {

/* A cross-section of a tube: an ellipse with half axes a and b. Seen from the next station, a to b runs
 * counterclockwise. */
struct Station
{
  Vec3f center, a, b;
};

/* Appends a closed tube through at least two stations, with 4 or 8 vertices around it (`sides`). Control points lie on
 * the ellipses, so the limit surface is slightly inside them. */
void appendTube(Cage& cage, const std::vector<Station>& stations, int sides);

/* A horn from a base circle along a direction, which bends towards another direction and tapers to a point.
 * `bend` is the distance of the tip from the straight line, in lengths; `flatness` is the ratio of the width across the
 * plane of the bend to the width in it. */
struct Horn
{
  Vec3f base, direction, bendTowards;
  float length, radius;
  float bend = 0.0f, flatness = 1.0f;
  int stations = 4;
};
void appendHorn(Cage& cage, const Horn& horn);

/* Appends a ball made from a cube with steps x steps quads per side. */
void appendBall(Cage& cage, Vec3f center, float radius, int steps);

} // namespace cbvh
