// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compressed moving subdivision surfaces match the hits of Embree's motion blur if vertices are on the lattice, with
 * every query and on every ISA. */

#include "kernels/cbvh/base/reference.h"
#include "kernels/cbvh/backend/flat_scene.h"
#include "support/filtered_geometry.h"
#include "support/moving_surface.h"
#include "support/query_forms.h"
#include "support/same_hits.h"
#include "support/scene.h"

#include <gtest/gtest.h>

#include <memory>

namespace programs::test { namespace {

constexpr uint32_t seed = 3101;

// Rotates about one axis and moves along another.
Vec turned(const Vec& p, double angle, double way) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {float(c * p[0] - s * p[1]), float(s * p[0] + c * p[1] + way), float(p[2] + 0.3 * way * p[0])};
}

Vec step(const Vec& p, unsigned i) { return turned(p, 0.25 * i, 0.2 * std::sin(i)); }

SurfaceSettings moving(Displacement& displacement, unsigned timeSteps) {
  SurfaceSettings settings;
  displacement.lattice = std::ldexp(1.0f, -12);
  settings.displacement = &displacement;
  settings.maxError = displacement.lattice;
  settings.compression = RTC_COMPRESSION_CVERT;
  settings.timeSteps = timeSteps;
  settings.motion = step;
  return settings;
}

class MovingSurfaces : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(Isas, MovingSurfaces, testing::Values(TEST_ISAS), nameOfIsa);

TEST_P(MovingSurfaces, HitsMatchEmbreeMotionBlur) {
  Random random(seed);
  Device device(GetParam());
  if (!device) GTEST_SKIP();
  for (unsigned timeSteps : {2u, 3u, 6u})
    for (const Cage& cage : {cubeCage(), prismCage(5), sheetCage(3)}) {
      Displacement displacement;
      const Twins twins(device, cage, moving(displacement, timeSteps));
      const RTCCompressionStatistics statistics = statisticsOf(twins.scene);
      ASSERT_GT(statistics.numMovingQuads, 0u);
      ASSERT_EQ(statistics.numMovingQuads, statistics.numQuads);
      ASSERT_EQ(statistics.numUncompressedQuads, 0u);
      SCOPED_TRACE(testing::Message() << timeSteps << " steps");
      ASSERT_NO_FATAL_FAILURE(expectSameQueries(twins.grid, twins.scene, timedRays(random, 600), 1e-3));
    }
}

// Also in moving instances.
TEST_P(MovingSurfaces, MasksFiltersAndInstances) {
  Random random(seed + 4);
  Device device(GetParam());
  if (!device) GTEST_SKIP();
  Displacement displacement;
  for (RTCCompression form : {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CTILE}) {
    const auto make = [&](RTCCompression compression) {
      SurfaceSettings settings = moving(displacement, 3);
      settings.compression = compression == RTC_COMPRESSION_NONE ? compression : form;
      return newSurface(device, cubeCage(), settings);
    };
    expectSameFilteredHits(device, make, true, timedRays(random, 600), 1e-3);
  }
}

// No displacement, so that the surface between two steps is the surface of the interpolated cage.
SurfaceSettings smooth(unsigned timeSteps, float begin, float end) {
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CVERT;
  settings.timeSteps = timeSteps;
  settings.begin = begin;
  settings.end = end;
  settings.motion = step;
  return settings;
}

// Interpolates the cage linearly at a time.
Cage cageAt(const Cage& cage, const SurfaceSettings& settings, float time) {
  const float at = (time - settings.begin) / (settings.end - settings.begin) * float(settings.timeSteps - 1);
  const unsigned before = std::min(unsigned(at), settings.timeSteps - 2);
  const float f = at - float(before);
  Cage between = cage;
  for (Vec& p : between.positions) {
    const Vec a = settings.motion(p, before), b = settings.motion(p, before + 1);
    for (int k = 0; k < 3; k++) p[k] = (1 - f) * a[k] + f * b[k];
  }
  return between;
}

// Hits on another part of the surface: at silhouettes, because the lattice moves vertices.
size_t countOthers(RTCScene grid, RTCScene scene, const std::vector<RTCRayHit>& rays, float slack) {
  size_t others = 0;
  for (const RTCRayHit& ray : rays) {
    const RTCRayHit a = intersect(grid, ray), b = intersect(scene, ray);
    if (isHit(a) != isHit(b)) {
      others++;
      continue;
    }
    if (!isHit(a)) continue;
    if (std::fabs(a.ray.tfar - b.ray.tfar) > slack * std::max(1.0, 0.1 / cosine(a)) || a.hit.primID != b.hit.primID)
      others++;
  }
  return others;
}

// Upstream's GRID does not support time ranges, so this test compares with static surfaces.
TEST(MovingSurfacesInTime, PositionsMatchStepsAndSurfacesExistOnlyInTheirRange) {
  Random random(seed + 1);
  Device device;
  const Cage cage = cubeCage();
  const SurfaceSettings ranges[] = {smooth(2, 0, 1), smooth(5, 0, 1), smooth(3, 0.25f, 0.75f), smooth(129, 0, 1),
                                    smooth(4, -1, 2)};
  for (const SurfaceSettings& settings : ranges) {
    SCOPED_TRACE(testing::Message() << settings.timeSteps << " steps from " << settings.begin << " to "
                                    << settings.end);
    const SurfaceScene scene(device, cage, settings);
    ASSERT_EQ(statisticsOf(scene).numMovingQuads, 6u * 256u);
    std::vector<float> times = {0, 0.25f, 0.5f, 0.75f, 1};
    for (int i = 0; i < 8; i++) times.push_back(float(random.uniform()));
    for (float time : times) {
      std::vector<RTCRayHit> rays = raysAt(random, 150);
      for (RTCRayHit& r : rays) r.ray.time = time;
      if (time < settings.begin || time > settings.end) {
        for (const RTCRayHit& r : rays) {
          ASSERT_FALSE(isHit(intersect(scene, r))) << "time " << time;
          ASSERT_FALSE(occluded(scene, r)) << "time " << time;
        }
        continue;
      }
      SurfaceSettings still;
      still.compression = RTC_COMPRESSION_NONE;
      const SurfaceScene grid(device, cageAt(cage, settings, time), still);
      EXPECT_LE(countOthers(grid, scene, rays, 0.01f), 2u) << "time " << time;
    }
  }
}

TEST(MovingSurfacesInTime, DifferentSurfacesShareAScene) {
  Random random(seed + 2);
  Device device;
  std::vector<SurfaceSettings> all = {smooth(2, 0, 1), smooth(7, 0.5f, 1), smooth(1, 0, 1), smooth(3, 0, 0.5f),
                                      smooth(1, 0, 1)};
  all[4].compression = RTC_COMPRESSION_NONE;
  Scene scene(device), motionOnly(device);
  std::vector<std::unique_ptr<SurfaceScene>> alone;
  for (size_t i = 0; i < all.size(); i++) {
    Cage cage = cubeCage();
    for (Vec& p : cage.positions)
      for (int k = 0; k < 3; k++) p[k] = 0.4f * p[k] + (i & (1u << k) ? 0.5f : -0.5f);
    addSurface(device, scene, cage, all[i]);
    alone.push_back(std::make_unique<SurfaceScene>(device, cage, all[i]));
  }
  rtcCommitScene(scene);
  EXPECT_EQ(statisticsOf(scene).numMovingQuads, 3u * 6u * 256u);
  const std::vector<RTCRayHit> rays = timedRays(random, 3000);
  for (QueryForm form : allQueryForms) {
    const std::vector<RTCRayHit> hits = closestHits(scene, rays, form), any = anyHits(scene, rays, form);
    size_t found = 0;
    for (size_t r = 0; r < rays.size(); r++) {
      RTCRayHit nearest = rays[r];
      unsigned surface = RTC_INVALID_GEOMETRY_ID;
      for (size_t i = 0; i < alone.size(); i++) {
        const RTCRayHit hit = intersect(*alone[i], rays[r]);
        if (isHit(hit) && hit.ray.tfar < nearest.ray.tfar) {
          nearest = hit;
          surface = unsigned(i);
        }
      }
      ASSERT_EQ(hits[r].hit.geomID, surface) << nameOf(form) << ", ray " << r;
      ASSERT_EQ(any[r].ray.tfar < 0, surface != RTC_INVALID_GEOMETRY_ID);
      if (surface == RTC_INVALID_GEOMETRY_ID) continue;
      found++;
      ASSERT_EQ(hits[r].hit.primID, nearest.hit.primID);
      ASSERT_NEAR(hits[r].ray.tfar, nearest.ray.tfar, 1e-5 * nearest.ray.tfar);
    }
    ASSERT_GT(found, 500u);
  }
}

// The second scene must find the boxes of the existing blocks.
TEST(MovingSurfacesInTime, ScenesShareBlocksOfAGeometry) {
  Random random(seed + 5);
  Device device;
  Displacement displacement;
  RTCGeometry geometry = newSurface(device, cubeCage(), moving(displacement, 3));
  Scene first(device), second(device);
  for (RTCScene scene : {RTCScene(first), RTCScene(second)}) {
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
  }
  rtcReleaseGeometry(geometry);
  for (const RTCRayHit& ray : timedRays(random, 1000)) {
    const RTCRayHit a = intersect(first, ray), b = intersect(second, ray);
    ASSERT_EQ(isHit(a), isHit(b));
    if (isHit(a)) {
      ASSERT_EQ(a.ray.tfar, b.ray.tfar);
      ASSERT_EQ(a.hit.primID, b.hit.primID);
    }
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(MovingSurfacesInTime, EditsTakeEffect) {
  Random random(seed + 3);
  Device device;
  const Cage cage = cubeCage();
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  SurfaceSettings settings = smooth(3, 0, 1);
  RTCGeometry geometry = newSurface(device, cage, settings);
  rtcAttachGeometry(scene, geometry);
  const auto check = [&](const char* what) {
    SCOPED_TRACE(what);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const SurfaceScene fresh(device, cage, settings);
    const std::vector<RTCRayHit> rays = timedRays(random, 400);
    for (const RTCRayHit& ray : rays) {
      const RTCRayHit a = intersect(fresh, ray), b = intersect(scene, ray);
      ASSERT_EQ(isHit(a), isHit(b));
      if (isHit(a)) {
        ASSERT_EQ(a.ray.tfar, b.ray.tfar);
        ASSERT_EQ(a.hit.primID, b.hit.primID);
      }
    }
    ASSERT_EQ(statisticsOf(scene).numMovingQuads, settings.timeSteps > 1 ? 6u * 256u : 0u);
    ASSERT_EQ(statisticsOf(scene).numQuads, 6u * 256u);
  };
  const auto setStep = [&](unsigned t) {
    std::vector<Vec> positions = cage.positions;
    for (Vec& p : positions) p = settings.motion(p, t);
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, t, RTC_FORMAT_FLOAT3, positions);
  };
  check("original");
  settings.motion = [](const Vec& p, unsigned i) { return i == 1 ? turned(p, -0.4, 0.3) : step(p, i); };
  setStep(1);
  check("one step's vertices");
  settings.timeSteps = 5;
  rtcSetGeometryTimeStepCount(geometry, 5);
  for (unsigned t = 0; t < 5; t++) setStep(t);
  check("more steps");
  settings.begin = 0.2f;
  settings.end = 0.6f;
  rtcSetGeometryTimeRange(geometry, settings.begin, settings.end);
  check("another range");
  settings.timeSteps = 2;
  rtcSetGeometryTimeStepCount(geometry, 2);
  check("fewer steps");
  settings.timeSteps = 1;
  rtcSetGeometryTimeStepCount(geometry, 1);
  check("it stops");
  settings.timeSteps = 2;
  rtcSetGeometryTimeStepCount(geometry, 2);
  setStep(1);
  check("moving again");
  rtcReleaseGeometry(geometry);
}

// Rays at the center of a moving sheet, whose tree splits time, at 65 times from 0 to 1.
TEST(MovingSurfacesInTime, SplitTimeIncludesItsEnds) {
  Device device;
  const std::vector<std::pair<float, float>> ranges = {{0, 1}, {0, 2}, {-1, 1}, {-1, 3}, {0, 1.0625f}, {0.25f, 0.75f}};
  for (const auto& range : ranges) {
    SurfaceSettings settings = smooth(9, 0, 1);
    settings.rate = 8;
    settings.begin = range.first;
    settings.end = range.second;
    settings.motion = orbiting;
    const SurfaceScene scene(device, sheetCage(4), settings);
    for (int i = 0; i <= 64; i++) {
      const float time = float(i) / 64, step = 8 * (time - range.first) / (range.second - range.first);
      const Vec from = settings.motion({0.1f, 0.1f, 0}, unsigned(std::clamp(std::floor(step), 0.0f, 8.0f)));
      const Vec to = settings.motion({0.1f, 0.1f, 0}, unsigned(std::clamp(std::ceil(step), 0.0f, 8.0f)));
      const float f = step - std::floor(step);
      RTCRayHit ray = makeRay({from[0] + f * (to[0] - from[0]), from[1] + f * (to[1] - from[1]), 5}, {0, 0, -1});
      ray.ray.time = time;
      EXPECT_EQ(isHit(intersect(scene, ray)), 0 <= step && step <= 8)
          << "range " << range.first << " to " << range.second << ", time " << time;
    }
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// With and without other geometry that Embree traces.
TEST(MovingSurfacesInTime, FirstUncompressedOneIsAddedToCompressedOnes) {
  for (bool hasTriangles : {false, true}) {
    SCOPED_TRACE(hasTriangles);
    Device device;
    Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
    SurfaceSettings settings = smooth(2, 0, 1);
    addSurface(device, scene, cubeCage(), settings);
    if (hasTriangles) {
      RTCGeometry triangle = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
      const std::vector<Vec> corners = {{7, 0, 0}, {8, 0, 0}, {7, 1, 0}};
      setBuffer(triangle, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, corners);
      setBuffer(triangle, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, std::vector<std::array<unsigned, 3>>{{0, 1, 2}});
      rtcCommitGeometry(triangle);
      attach(scene, triangle);
    }
    rtcCommitScene(scene);
    Cage second = cubeCage();
    for (Vec& p : second.positions) p[0] += 4;
    settings.compression = RTC_COMPRESSION_NONE;
    const unsigned added = addSurface(device, scene, second, settings);
    rtcCommitScene(scene);
    EXPECT_EQ(intersect(scene, makeRay({0, 0, 5}, {0, 0, -1})).hit.geomID, 0u);
    EXPECT_EQ(intersect(scene, makeRay({4, 0, 5}, {0, 0, -1})).hit.geomID, added);
    EXPECT_EQ(isHit(intersect(scene, makeRay({7.2f, 0.2f, 5}, {0, 0, -1}))), hasTriangles);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  }
}

// Such a surface has a tree without blocks.
TEST_P(MovingSurfaces, SurfaceOfHolesHidesNoStaticOneInFlatScenes) {
  using namespace embree::cbvh;
  Device device(GetParam());
  if (!device) GTEST_SKIP();
  for (bool isMovingFirst : {false, true}) {
    SCOPED_TRACE(isMovingFirst);
    Scene scene(device);
    for (bool moves : {isMovingFirst, !isMovingFirst}) {
      Cage cage = quadCage();
      if (moves) cage.holes = {0};
      SurfaceSettings settings;
      settings.compression = RTC_COMPRESSION_CVERT;
      settings.timeSteps = moves ? 2 : 1;
      addSurface(device, scene, cage, settings);
    }
    rtcCommitScene(scene);
    EXPECT_TRUE(isHit(intersect(scene, makeRay({0.3f, 0.4f, 5}, {0, 0, -1}))));
    const FlatScene* flat = rtcFlattenScene(scene, flatSceneVersion);
    ASSERT_NE(flat, nullptr) << device.message;
    EXPECT_NE(flat->staticTree.root, emptyReference);
    EXPECT_EQ(flat->movingTree.root, emptyReference);
    EXPECT_GT(flat->numBlocks, 0u);
    rtcReleaseFlatScene(flat);
  }
}

// Some ranges begin or end close to a step of another surface, where trees split time.
TEST_P(MovingSurfaces, DifferentRangesTogetherMatchSeparateScenes) {
  Random random(seed + 9);
  Device device(GetParam());
  if (!device) GTEST_SKIP();
  const std::array<float, 2> ranges[] = {{0, 0.5f}, {0.25f, 0.75f}, {0.5f, 1}, {0, 1}, {0, 0.50003f}, {0.49997f, 1}};
  for (unsigned firsts : {3u, 6u}) {
    Displacement displacements[6];
    Scene scene(device);
    std::vector<std::unique_ptr<Scene>> alone;
    for (unsigned i = 0; i < firsts; i++) {
      SurfaceSettings settings = moving(displacements[i], i == 3 ? 9 : 2 + i);
      displacements[i].offset = {0.8f * float(i) - 0.4f * float(firsts - 1), 0, 0};
      displacements[i].scale = 0.5f;
      settings.rate = 8;
      settings.begin = ranges[i][0];
      settings.end = ranges[i][1];
      addSurface(device, scene, cubeCage(), settings);
      alone.emplace_back(new Scene(device));
      addSurface(device, *alone.back(), cubeCage(), settings);
      rtcCommitScene(*alone.back());
    }
    rtcCommitScene(scene);
    size_t hits = 0;
    for (RTCRayHit ray : raysAt(random, 8000)) {
      ray.ray.time = float(random.chance(0.5) ? random.uniform() : random.uniform(0.49995, 0.50005));
      float nearest = INFINITY;
      for (const auto& one : alone)
        nearest = std::min(nearest, isHit(intersect(*one, ray)) ? intersect(*one, ray).ray.tfar : INFINITY);
      const RTCRayHit found = intersect(scene, ray);
      ASSERT_EQ(found.ray.tfar, nearest) << "time " << ray.ray.time;
      hits += isHit(found);
    }
    EXPECT_GT(hits, 1000u);
  }
}

}} // namespace programs::test
