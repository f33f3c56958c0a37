// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Closed pieces of all-quad cages: tubes along a curve, for limbs, horns, teeth and
 * blades, and balls. */

#include "surface/cage.h"

#include <vector>

namespace cbvh {

/* A cross-section of a tube: an ellipse with two half axes that span its plane. Seen
 * from the next station, a to b runs counterclockwise. */
struct Station
{
  Vec3f center, a, b;
};

/* Adds a tube through stations, at least two, closed by caps. sides: 4 or 8 vertices
 * around. The control points lie on the ellipses, so the limit surface is a little
 * inside them. */
void appendTube(Cage& cage, const std::vector<Station>& stations, int sides);

/* Stations of a horn: from a base circle along a direction, bending towards another
 * one, thinning to a point.
 * bend: how far the tip is off the straight line, in lengths. flatness: width across
 * the plane of the bend over width in it. */
struct Horn
{
  Vec3f base, direction, bendTowards;
  float length, radius;
  float bend = 0.0f, flatness = 1.0f;
  int stations = 4;
};
void appendHorn(Cage& cage, const Horn& horn);

/* Adds a ball out of a cube of steps x steps quads a side. */
void appendBall(Cage& cage, Vec3f center, float radius, int steps);

} // namespace cbvh
