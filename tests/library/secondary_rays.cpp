// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays that leave the surface do not hit it again immediately. */

#include "support/displaced_sheet.h"

#include <cmath>
#include <cstdio>

namespace programs::test { namespace {

// Rays with an offset of a hundredth of a quad must see the sky if GRID's do, except for one in a thousand that leave
// their block within half a bin of a leaf.
TEST(SecondaryRays, RaysFromSurfaceDoNotHitItAgain) {
  DisplaceFunction waves = [](unsigned, float u, float v, Vec& p) {
    p[2] = 0.01f * std::sin(9 * u + 2 * v) * std::cos(11 * v);
  };
  Device stock, device("subdiv_accel=cbvh.leaf");
  Scene grid(stock), scene(device);
  commit(grid, newSheet(stock, 1, 0, 64, waves));
  commit(scene, newSheet(device, 1, 0, 64, waves));
  Random random(5);
  int rays = 0, wrong = 0;
  for (int i = 0; i < 20000; i++) {
    const Vec dir = {float(0.4 * random.normal()), float(0.4 * random.normal()), -1};
    const float x = float(random.uniform(0.1, 0.9)), y = float(random.uniform(0.1, 0.9));
    const RTCRayHit ray = makeRay({x - dir[0], y - dir[1], 1}, dir);
    const double r = random.uniform(), a = 2 * M_PI * random.uniform();
    const Vec bounce = {float(std::sqrt(r) * std::cos(a)), float(std::sqrt(r) * std::sin(a)), float(std::sqrt(1 - r))};
    bool seen[2];
    bool both = true;
    for (int k = 0; k < 2; k++) {
      const RTCRayHit hit = intersect(k ? RTCScene(scene) : RTCScene(grid), ray);
      both &= isHit(hit);
      const float t = hit.ray.tfar;
      seen[k] = occluded(
          k ? RTCScene(scene) : RTCScene(grid),
          makeRay({ray.ray.org_x + t * dir[0], ray.ray.org_y + t * dir[1], ray.ray.org_z + t * dir[2] + 0.01f / 64},
                  bounce));
    }
    if (!both) continue;
    rays++;
    wrong += seen[0] != seen[1];
  }
  EXPECT_GT(rays, 15000);
  EXPECT_LE(wrong, rays / 1000) << wrong << " of " << rays;
  std::printf("%d of %d rays differ from GRID's\n", wrong, rays);
}

}} // namespace programs::test
