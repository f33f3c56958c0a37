// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Surfaces that are hard to build or to trace, and are no case of hard_*.cpp: displacement
 * that changes its mind, rays that leave the surface. */

#include "test_random.h"
#include "test_scene.h"

#include <algorithm>
#include <cstdio>

namespace cbvh {
namespace {

using DisplaceFunction = std::function<void(unsigned primID, float u, float v, Vec& p)>;

// One geometry of separate unit faces along x, at y, displaced by a function.
RTCGeometry newSheet(RTCDevice device, unsigned faces, float x0, float rate, DisplaceFunction& displace)
{
  Cage cage;
  for (unsigned f = 0; f < faces; f++) {
    const float x = x0 + f;
    for (const Vec& p : {Vec{x,0,0}, Vec{x+1,0,0}, Vec{x+1,1,0}, Vec{x,1,0}}) cage.positions.push_back(p);
    cage.addFace({4*f, 4*f+1, 4*f+2, 4*f+3});
  }
  cage.mode = RTC_SUBDIVISION_MODE_PIN_ALL;
  SurfaceSettings settings;
  settings.rate = rate;
  RTCGeometry geometry = newSurface(device, cage, settings);
  rtcSetGeometryUserData(geometry, &displace);
  rtcSetGeometryDisplacementFunction(geometry, [](const RTCDisplacementFunctionNArguments* args) {
    for (unsigned i = 0; i < args->N; i++) {
      Vec p = {args->P_x[i], args->P_y[i], args->P_z[i]};
      (*(DisplaceFunction*)args->geometryUserPtr)(args->primID, args->u[i], args->v[i], p);
      args->P_x[i] = p[0]; args->P_y[i] = p[1]; args->P_z[i] = p[2];
    }
  });
  return geometry;
}

void commit(RTCScene scene, RTCGeometry geometry)
{
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
}

// A face that loses all its vertices leaves no block, and takes none from the mesh behind
// it, whichever tasks build the two.
TEST(HardSurfaces, AFaceWithoutVerticesTakesNothingFromItsNeighbours)
{
  Device device("threads=1,subdiv_accel=cbvh.leaf");
  Scene scene(device);
  DisplaceFunction poison = [](unsigned primID, float, float, Vec& p) { if (primID == 0) p[2] = NAN; }, none = [](unsigned, float, float, Vec&) {};
  for (int m = 0; m < 2; m++) {
    RTCGeometry geometry = newSheet(device, m ? 4 : 2, 10.f*m, 64, m ? none : poison);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 4096u);
  for (int f = 0; f < 6; f++)
    for (int i = 0; i < 64; i++) {
      const float x = (f < 2 ? f : 10 + f - 2) + (i % 8 + 0.3f)/8, y = (i/8 + 0.4f)/8;
      EXPECT_EQ(isHit(intersect(scene, makeRay({x, y, 1}, {0, 0, -1}))), f != 0) << "face " << f << " at " << x << ", " << y;
    }
}

// Frame levels of an error bound are decided once, so a displacement that gives other
// values when it is asked again cannot ask for more room than there is.
TEST(HardSurfaces, ADisplacementMayAnswerDifferentlyTheSecondTime)
{
  Device device("threads=1,subdiv_accel=cbvh.leaf,cbvh_frame_level=auto,cbvh_max_error=0.0005");
  Scene scene(device);
  size_t calls = 0;
  DisplaceFunction rougher = [&](unsigned, float u, float v, Vec& p) {
    const float amplitude = calls++ < 4*33*33 ? 0.f : 0.1f;
    p[2] = amplitude*std::sin(40*u)*std::sin(40*v);
  };
  commit(scene, newSheet(device, 4, 0, 32, rougher));
  ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_EQ(statisticsOf(scene).numBlocks, 4u);
}

// A compressed geometry without faces has no accelerator, which is no reason to make new
// ones at every commit of a dynamic scene: others would be rebuilt from nothing.
TEST(HardSurfaces, AGeometryWithoutFacesIsNoReasonToRebuild)
{
  Device device("subdiv_accel=cbvh.leaf");
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  SurfaceSettings settings;
  addSurface(device, scene, Cage(), settings);
  rtcCommitScene(scene);
  rtcCommitScene(scene);
  const RTCCompressionStatistics stats = statisticsOf(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_EQ(stats.numBlocks + stats.numQuads + stats.topLevelBytes, 0u);
}

// Rays that leave a hit by an offset of a hundredth of a quad see the sky where GRID's do.
// Those that do not leave their block through its border within half a bin of a leaf,
// where the thickness of leaves still counts: at most one in a thousand of all rays.
TEST(HardSurfaces, RaysFromTheSurfaceDoNotHitItAgain)
{
  DisplaceFunction waves = [](unsigned, float u, float v, Vec& p) { p[2] = 0.01f*std::sin(9*u + 2*v)*std::cos(11*v); };
  Device stock, device("subdiv_accel=cbvh.leaf");
  Scene grid(stock), scene(device);
  commit(grid, newSheet(stock, 1, 0, 64, waves));
  commit(scene, newSheet(device, 1, 0, 64, waves));
  Random random(5);
  int rays = 0, wrong = 0;
  for (int i = 0; i < 20000; i++) {
    const Vec dir = {float(0.4*random.normal()), float(0.4*random.normal()), -1};
    const float x = float(random.uniform(0.1, 0.9)), y = float(random.uniform(0.1, 0.9));
    const RTCRayHit ray = makeRay({x - dir[0], y - dir[1], 1}, dir);
    const double r = random.uniform(), a = 2*M_PI*random.uniform();
    const Vec bounce = {float(std::sqrt(r)*std::cos(a)), float(std::sqrt(r)*std::sin(a)), float(std::sqrt(1-r))};
    bool seen[2];
    bool both = true;
    for (int k = 0; k < 2; k++) {
      const RTCRayHit hit = intersect(k ? RTCScene(scene) : RTCScene(grid), ray);
      both &= isHit(hit);
      const float t = hit.ray.tfar;
      seen[k] = occluded(k ? RTCScene(scene) : RTCScene(grid),
        makeRay({ray.ray.org_x + t*dir[0], ray.ray.org_y + t*dir[1], ray.ray.org_z + t*dir[2] + 0.01f/64}, bounce));
    }
    if (!both) continue;
    rays++;
    wrong += seen[0] != seen[1];
  }
  EXPECT_GT(rays, 15000);
  EXPECT_LE(wrong, rays/1000) << wrong << " of " << rays;
  std::printf("%d of %d rays see what GRID's do not, or the other way round\n", wrong, rays);
}

} // namespace
} // namespace cbvh
