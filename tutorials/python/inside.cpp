// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "inside.h"
#include "all_hits.h"

#include <cmath>
#include <vector>

namespace programs::python {
namespace {

/* Far from all axes, diagonals and each other, so that they are parallel to few edges of real meshes. */
constexpr Vec3f directions[3] = {{0.8253561f, 0.4317826f, 0.3639147f},
                                 {-0.2718459f, 0.7390851f, -0.6163524f},
                                 {-0.5671433f, -0.6180953f, 0.5443310f}};

/* Hits at the same distance or at adjacent floats count as one: they are at an edge. */
bool crossesOddly(RTCScene scene, Vec3f point, Vec3f direction, float time) {
  std::vector<RTCRayHit> hits;
  findAllHits(scene, Ray{point, 0.0f, direction, INFINITY, time}, hits);
  bool isOdd = false;
  float after = -INFINITY;
  for (const RTCRayHit& hit : hits) {
    if (hit.ray.tfar > after) isOdd = !isOdd;
    after = std::nextafter(hit.ray.tfar, INFINITY);
  }
  return isOdd;
}

} // namespace

bool isInside(RTCScene scene, Vec3f point, float time) {
  const bool first = crossesOddly(scene, point, directions[0], time);
  if (first == crossesOddly(scene, point, directions[1], time)) return first;
  return crossesOddly(scene, point, directions[2], time);
}

} // namespace programs::python
