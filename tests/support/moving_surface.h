// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A motion of cages, and rays from the center of moving compressed surfaces at vertices and edges. */

#include "support/scene.h"
#include "support/surface_access.h"

namespace programs::test {

inline Vec twisted(const Vec& p, double angle) {
  const double a = angle * (1 + p[2]), c = std::cos(a), s = std::sin(a);
  return {float(c * p[0] - s * p[1]), float(s * p[0] + c * p[1]), float(p[2] + 0.1 * angle)};
}

// An eighth of a turn per step around the z axis, 3 units from it: so fast that trees of moving blocks split time.
inline Vec orbiting(const Vec& p, unsigned step) {
  const double a = M_PI / 4 * step, x = p[0] + 3.0, c = std::cos(a), s = std::sin(a);
  return {float(c * x - s * p[1]), float(s * x + c * p[1]), p[2]};
}

// Vertices at a time, and points on the edges between them.
struct MovingTargets {
  std::vector<Vec> points;

  MovingTargets(RTCGeometry geometry, float time) { forEachStoredPart(geometry, time, add, this); }

  static bool add(void* self, const CbvhPart* part) {
    const auto vertex = [&](unsigned x, unsigned y) {
      const float* p = part->vertices + 3 * (y * part->width + x);
      return Vec{p[0], p[1], p[2]};
    };
    for (unsigned y = 0; y < part->height; y++)
      for (unsigned x = 0; x < part->width; x++) {
        const Vec a = vertex(x, y);
        ((MovingTargets*)self)->points.push_back(a);
        if (x + 1 == part->width) continue;
        const Vec b = vertex(x + 1, y);
        ((MovingTargets*)self)
            ->points.push_back({0.7f * a[0] + 0.3f * b[0], 0.7f * a[1] + 0.3f * b[1], 0.7f * a[2] + 0.3f * b[2]});
      }
    return true;
  }
};

// Rays at the given number of times. The first two times are 0 and 1.
inline std::vector<RTCRayHit> raysAtMovingSurface(Random& random, RTCGeometry geometry, unsigned times,
                                                  unsigned raysPerTime) {
  std::vector<RTCRayHit> rays;
  for (unsigned t = 0; t < times; t++) {
    const float time = t == 0 ? 0.0f : t == 1 ? 1.0f : float(random.uniform());
    const MovingTargets targets(geometry, time);
    Vec middle{0, 0, 0};
    for (const Vec& p : targets.points)
      for (int k = 0; k < 3; k++) middle[k] += p[k] / float(targets.points.size());
    for (unsigned i = 0; i < raysPerTime; i++) {
      const Vec& p = targets.points[random.below(uint32_t(targets.points.size()))];
      rays.push_back(makeRay(middle, {p[0] - middle[0], p[1] - middle[1], p[2] - middle[2]}));
      rays.back().ray.time = time;
    }
  }
  return rays;
}

inline std::vector<RTCRayHit> timedRays(Random& random, unsigned count) {
  std::vector<RTCRayHit> rays = raysAt(random, count);
  for (RTCRayHit& r : rays) r.ray.time = float(random.uniform());
  return rays;
}

} // namespace programs::test
