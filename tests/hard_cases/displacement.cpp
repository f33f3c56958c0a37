// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Hard cases: displacement through the API, compared with GRID. blocks.cpp tests displacement inside a block. */

#include "hard_cases/hard_case.h"
#include "support/grid_agreement.h"

namespace programs::test { namespace {

class HardDisplacement : public HardCase {
protected:
  // Rays from inside and outside of a displaced cube.
  void expectTightAndNear(Displacement& displacement, float rate) {
    Random random(61);
    std::vector<RTCRayHit> inside;
    for (int i = 0; i < 2000; i++)
      inside.push_back(makeRay({0, 0, 0}, {float(random.normal()), float(random.normal()), float(random.normal())}));
    for (int frameLevel : {0, 2}) {
      SCOPED_TRACE(testing::Message() << "amplitude " << displacement.amplitude << ", frame level " << frameLevel);
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.rate = rate;
      settings.compression = compression();
      settings.frameLevel = frameLevel;
      const Twins twins(device, cubeCage(), settings);
      const std::vector<RTCRayHit> outside = raysAt(random, 1000);
      if (compression() == RTC_COMPRESSION_CGRID) expectEqualToGrid(twins.grid, twins.scene, outside, cubeCage());
      else expectHitsNearGrid(twins.grid, twins.scene, outside);
      if (HasFatalFailure()) return;
      expectNoLeaks(twins.grid, twins.scene, inside, compression());
    }
  }
};
INSTANTIATE_TEST_SUITE_P(HardCases, HardDisplacement, testing::ValuesIn(tracers()), tracerName);

TEST_P(HardDisplacement, FiveFold) {
  property("displaced five times as far, a quarter of a face wide, every hit is within its leaf's box of GRID's "
           "surface, and "
           "no ray from inside leaks");
  Displacement displacement;
  displacement.amplitude *= 5;
  expectTightAndNear(displacement, 16);
}

TEST_P(HardDisplacement, Rough) {
  property(
      "displaced by waves of two quads' length, every hit is within its leaf's box of GRID's surface, and no ray from "
      "inside leaks");
  Displacement displacement;
  displacement.frequency = 50;
  expectTightAndNear(displacement, 16);
}

// Folds share x and y in a block's frame: the nearest part counts, not the first one in traversal order.
TEST_P(HardDisplacement, FoldsAreHitAtNearestPart) {
  property(
      "if a surface folds over its own block, the closest hit is on the nearest part of it, not on the first part that "
      "is visited");
  const auto roll = [](const RTCDisplacementFunctionNArguments* args) {
    for (unsigned i = 0; i < args->N; i++) {
      const float u = args->u[i], v = args->v[i], a = 6 * float(M_PI) * u, b = 6 * float(M_PI) * v;
      args->P_x[i] = u - 0.12f * std::sin(a);
      args->P_y[i] = v - 0.12f * std::sin(b);
      args->P_z[i] = 0.05f * (std::cos(a) + std::cos(b));
    }
  };
  auto commit = [&](RTCScene scene, RTCCompression compression, int frameLevel) {
    SurfaceSettings settings;
    settings.rate = 64;
    settings.compression = compression;
    settings.frameLevel = frameLevel;
    RTCGeometry geometry = newSurface(device, quadCage(), settings);
    rtcSetGeometryDisplacementFunction(geometry, roll);
    rtcCommitGeometry(geometry);
    attach(scene, geometry);
    rtcCommitScene(scene);
  };
  Scene grid(device);
  commit(grid, RTC_COMPRESSION_NONE, 0);
  for (int frameLevel : {1, 2, 3}) {
    Scene scene(device);
    commit(scene, compression(), frameLevel);
    Random random(11);
    int hits = 0, behind = 0;
    for (int i = 0; i < 2000; i++) {
      const Vec target = {float(random.uniform(0.2, 0.8)), float(random.uniform(0.2, 0.8)), 0};
      const Vec dir = {float(0.5 * random.normal()), float(0.5 * random.normal()), -1};
      const RTCRayHit ray = makeRay({target[0] - dir[0], target[1] - dir[1], 1}, dir);
      const RTCRayHit a = intersect(grid, ray), b = intersect(scene, ray);
      if (!isHit(a)) continue;
      hits++;
      behind += !isHit(b) || b.ray.tfar > a.ray.tfar + 0.02f;
    }
    EXPECT_GT(hits, 1500);
    // the rest are leaves seen from the side, which are solid or missed within their thickness
    EXPECT_LE(behind, compression() == RTC_COMPRESSION_CLEAF ? hits / 100 : 0) << "frame level " << frameLevel;
  }
}

}} // namespace programs::test
