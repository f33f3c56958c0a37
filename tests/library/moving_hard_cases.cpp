// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Difficult moving surfaces: closed ones never leak. Vertices that are not finite at one step, and surfaces that turn
 * inside out, collapse or move far away, neither crash nor disappear. */

#include "support/diced_mesh.h"
#include "support/message_parts.h"
#include "support/moving_surface.h"
#include "support/saved.h"
#include "support/surface_access.h"

#include <gtest/gtest.h>

namespace programs::test { namespace {

constexpr uint32_t seed = 3131;

SurfaceSettings moving(Displacement& displacement, unsigned timeSteps) {
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = RTC_COMPRESSION_CVERT;
  settings.timeSteps = timeSteps;
  settings.motion = [](const Vec& p, unsigned i) { return twisted(p, 0.3 * i); };
  return settings;
}

// Number of rays from the center of a closed surface that leave it.
size_t countLeaks(Random& random, RTCGeometry geometry, RTCScene scene, unsigned times, unsigned raysPerTime,
                  size_t& rays) {
  size_t leaks = 0;
  for (const RTCRayHit& ray : raysAtMovingSurface(random, geometry, times, raysPerTime)) {
    leaks += !isHit(intersect(scene, ray)) || !occluded(scene, ray);
    rays++;
  }
  return leaks;
}

TEST(MovingHardCases, ClosedSurfacesDoNotLeakAtAnyTime) {
  Random random(seed);
  size_t rays = 0;
  for (const char* isa : {"", "isa=avx2", "isa=sse2"}) {
    Device device(isa);
    if (!device) continue;
    const Cage cages[] = {cubeCage(), prismCage(3), prismCage(7), trapezohedronCage(5)};
    for (const Cage& cage : cages)
      for (unsigned timeSteps : {2u, 4u}) {
        Displacement displacement;
        displacement.amplitude = 0.1f;
        SurfaceSettings settings = moving(displacement, timeSteps);
        if (timeSteps == 2 || cage.faces.size() == 6) settings.compression = RTC_COMPRESSION_CTILE;
        // also different on both sides of an edge
        for (size_t i = 0; i < cage.indices.size(); i++) settings.edgeRates.push_back(float(1 + (7 * i) % 43));
        RTCGeometry geometry = newSurface(device, cage, settings);
        Scene scene(device);
        rtcAttachGeometry(scene, geometry);
        rtcCommitScene(scene);
        EXPECT_EQ(countLeaks(random, geometry, scene, 12, 400, rays), 0u)
            << cage.faces.size() << " faces, " << timeSteps << " steps, " << isa;
        rtcReleaseGeometry(geometry);
      }
  }
  EXPECT_GT(rays, 30000u);
}

// Counts the rays that hit a surface, and checks all hits.
size_t countHits(RTCScene scene, Random& random, float from = 0, float to = 1) {
  size_t hits = 0;
  for (RTCRayHit ray : raysAt(random, 500)) {
    ray.ray.time = float(random.uniform(from, to));
    const RTCRayHit hit = intersect(scene, ray);
    EXPECT_EQ(isHit(hit), occluded(scene, ray));
    if (!isHit(hit)) continue;
    hits++;
    EXPECT_TRUE(std::isfinite(hit.ray.tfar) && std::isfinite(hit.hit.u) && std::isfinite(hit.hit.v) &&
                std::isfinite(hit.hit.Ng_x));
    EXPECT_TRUE(hit.hit.u >= 0 && hit.hit.u <= 1 && hit.hit.v >= 0 && hit.hit.v <= 1);
  }
  return hits;
}

TEST(MovingHardCases, NonFiniteVertexAtOneStepRemovesItsQuadsAroundThatStep) {
  Random random(seed + 1);
  for (unsigned bad : {0u, 1u, 3u}) {
    Device device;
    SurfaceSettings settings;
    settings.compression = RTC_COMPRESSION_CVERT;
    settings.timeSteps = 4;
    settings.motion = [bad](const Vec& p, unsigned i) {
      return i == bad && p[0] < 0 && p[1] < 0 && p[2] < 0 ? Vec{NAN, 0, 0} : twisted(p, 0.2 * i);
    };
    const SurfaceScene scene(device, cubeCage(), settings);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(containsInOrder(device.message, {"geometry 0, face 0:", "finite"}));
    EXPECT_GT(statisticsOf(scene).numInvalidQuads, 0u);
    // segments without that step are complete
    const float begin = bad == 3 ? 0.0f : bad == 0 ? 0.34f : 0.67f, end = bad == 3 ? 0.66f : 1.0f;
    settings.motion = [](const Vec& p, unsigned i) { return twisted(p, 0.2 * i); };
    const SurfaceScene whole(device, cubeCage(), settings);
    for (RTCRayHit ray : raysAt(random, 400)) {
      ray.ray.time = float(random.uniform(begin, end));
      EXPECT_EQ(isHit(intersect(scene, ray)), isHit(intersect(whole, ray)))
          << "step " << bad << ", time " << ray.ray.time;
    }
    EXPECT_GT(countHits(scene, random), 100u);
  }
}

// A group has no finite vertex at the first step. The second scene and the loaded geometry find the boxes of the steps
// in the blocks.
TEST(MovingHardCases, GroupWithoutFiniteVerticesAtOneStepIsHitAtOtherTimes) {
  Random random(seed + 10);
  Device device;
  Diced diced;
  for (unsigned i : {0u, 1u})
    diced.add(17, 17,
              [&](unsigned x, unsigned y) { return Vec{float(x), float(y + 100 * i), 0.01f * float((x + y) % 5)}; });
  diced.motion = [](const Vec& p, unsigned step) {
    return step == 0 && p[0] >= 12 && p[1] < 50 ? Vec{NAN, NAN, NAN} : Vec{p[0], p[1], p[2] + 0.1f * step};
  };
  const RTCGeometry geometry = newGrids(device, diced, RTC_COMPRESSION_CVERT, 0, 4);
  Scene first(device), second(device), ofFile(device);
  for (RTCScene scene : {RTCScene(first), RTCScene(second)}) {
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
  }
  Folder folder;
  ASSERT_TRUE(saveGeometryFile(geometry, (folder / "moving").c_str())) << device.message;
  const RTCGeometry loaded = loadGeometryFile(device, (folder / "moving").c_str());
  ASSERT_NE(loaded, nullptr) << device.message;
  rtcCommitGeometry(loaded);
  rtcAttachGeometry(ofFile, loaded);
  rtcCommitScene(ofFile);
  rtcReleaseGeometry(geometry);
  rtcReleaseGeometry(loaded);
  for (int i = 0; i < 2000; i++) {
    RTCRayHit ray = makeRay({float(random.uniform(0.1, 15.9)), float(random.uniform(0.1, 15.9)), 5}, {0, 0, -1});
    ray.ray.time = float(random.uniform(0.34, 1)); // after the first segment
    SCOPED_TRACE(testing::Message() << "x " << ray.ray.org_x << ", y " << ray.ray.org_y << ", time " << ray.ray.time);
    ASSERT_TRUE(isHit(intersect(first, ray)));
    ASSERT_TRUE(isHit(intersect(second, ray)));
    ASSERT_TRUE(isHit(intersect(ofFile, ray)));
  }
}

TEST(MovingHardCases, ReversedStepsMatchReversedTimes) {
  Random random(seed + 2);
  Device device;
  Displacement displacement;
  SurfaceSettings settings = moving(displacement, 5);
  const SurfaceScene forwards(device, cubeCage(), settings);
  settings.motion = [](const Vec& p, unsigned i) { return twisted(p, 0.3 * (4 - i)); };
  const SurfaceScene backwards(device, cubeCage(), settings);
  size_t others = 0;
  for (RTCRayHit ray : raysAt(random, 1000)) {
    ray.ray.time = float(random.below(65)) / 64;
    const RTCRayHit a = intersect(forwards, ray);
    ray.ray.time = 1 - ray.ray.time;
    const RTCRayHit b = intersect(backwards, ray);
    others += isHit(a) != isHit(b) || (isHit(a) && std::fabs(a.ray.tfar - b.ray.tfar) > 1e-3f * a.ray.tfar);
  }
  EXPECT_LE(others, 3u);
}

TEST(MovingHardCases, InvertedCollapsedAndDistantSurfacesAreTraced) {
  Random random(seed + 3);
  const std::function<Vec(const Vec&, unsigned)> motions[] = {
      [](const Vec& p, unsigned i) { return i ? Vec{-p[0], -p[1], -p[2]} : p; }, // through a point, turning inside out
      [](const Vec& p, unsigned i) { return i ? Vec{0.1f, 0.2f, 0.3f} : p; },    // to a point
      [](const Vec& p, unsigned i) { return i ? p : Vec{0.1f, 0.2f, 0.3f}; },    // from a point
      [](const Vec& p, unsigned i) { return i ? Vec{p[0] + 2e5f, p[1], p[2]} : p; }, // by 10^5 times its size
      [](const Vec& p, unsigned i) {
        return i ? Vec{1e4f * p[0], 1e4f * p[1], 1e4f * p[2]} : p;
      },                                        // grows by a factor of 10^4
      [](const Vec& p, unsigned) { return p; }, // no motion
  };
  for (size_t m = 0; m < std::size(motions); m++) {
    SCOPED_TRACE(testing::Message() << "motion " << m);
    Device device;
    Displacement displacement;
    displacement.amplitude = m < 5 ? 0.0f : 0.05f;
    SurfaceSettings settings = moving(displacement, 2);
    settings.motion = motions[m];
    const SurfaceScene scene(device, cubeCage(), settings);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_EQ(statisticsOf(scene).numMovingQuads, 6u * 256u);
    const float to = m == 3 || m == 4 ? 1e-6f : 1.0f;
    EXPECT_GT(countHits(scene, random, m == 2 ? 0.2f : 0, to), m == 1 || m == 2 ? 50u : 100u);
    const SurfaceScene grid(device, cubeCage(), [&] {
      SurfaceSettings s = settings;
      s.compression = RTC_COMPRESSION_NONE;
      return s;
    }());
    size_t others = 0, hits = 0;
    for (RTCRayHit ray : raysAt(random, 500)) {
      ray.ray.time = float(random.uniform(0, to));
      const RTCRayHit a = intersect(grid, ray), b = intersect(scene, ray);
      others += isHit(a) != isHit(b);
      hits += isHit(a);
    }
    EXPECT_LE(others, 3 + hits / 50);
  }
}

TEST(MovingHardCases, TimesOfStepsMatchSteps) {
  Random random(seed + 4);
  Device device;
  const unsigned timeSteps = 129;
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CVERT;
  settings.timeSteps = timeSteps;
  settings.rate = 4;
  settings.motion = [](const Vec& p, unsigned i) { return twisted(p, 0.02 * i); };
  const SurfaceScene scene(device, cubeCage(), settings);
  for (unsigned s = 0; s < timeSteps; s += 16) {
    SurfaceSettings still;
    still.compression = RTC_COMPRESSION_CVERT;
    still.rate = 4;
    Cage cage = cubeCage();
    for (Vec& p : cage.positions) p = settings.motion(p, s);
    const SurfaceScene atStep(device, cage, still);
    for (RTCRayHit ray : raysAt(random, 100)) {
      ray.ray.time = float(s) / 128;
      const RTCRayHit a = intersect(atStep, ray), b = intersect(scene, ray);
      ASSERT_EQ(isHit(a), isHit(b)) << "step " << s;
      if (isHit(a)) { ASSERT_NEAR(a.ray.tfar, b.ray.tfar, 1e-3 * a.ray.tfar) << "step " << s; }
    }
  }
}

enum class Size { Primitive, Block, Many };

std::vector<std::pair<std::string, RTCGeometry>> movingSurfaces(RTCDevice device, Size size, float begin, float end,
                                                                unsigned timeSteps = 2) {
  std::vector<std::pair<std::string, RTCGeometry>> all;
  const DicedMotion motion = [](const Vec& p, unsigned step) { return Vec{p[0], p[1], p[2] + 0.25f * float(step)}; };
  Diced grids = size == Size::Primitive ? dicedSheet(1, 2) : dicedSheet(size == Size::Block ? 1 : 4, 16);
  grids.motion = motion;
  Random random(3);
  DicedMesh mesh = meshOf(grids, QuadOrder::Rows, random);
  if (size == Size::Primitive) mesh.quads.resize(1);
  mesh.motion = motion;
  SurfaceSettings settings;
  settings.rate = size == Size::Many ? 24 : 4;
  settings.timeSteps = timeSteps;
  settings.motion = motion;
  all.push_back({"cage", newSurface(device, size == Size::Many ? cubeCage() : quadCage(), settings)});
  all.push_back({"grids", newGrids(device, grids, RTC_COMPRESSION_INHERIT, 0, timeSteps)});
  all.push_back({"quads", newMesh(device, mesh, RTC_COMPRESSION_INHERIT, 0, timeSteps)});
  all.push_back({"triangles", newMesh(device, trianglesOf(mesh), RTC_COMPRESSION_INHERIT, 0, timeSteps)});
  for (const auto& [name, geometry] : all) {
    rtcSetGeometryTimeRange(geometry, begin, end);
    rtcCommitGeometry(geometry);
  }
  return all;
}

// Ranges that end before 0, begin after 1, or touch these limits: nothing is read out of bounds, and surfaces are
// visible only at the instant that their range touches.
TEST(MovingHardCases, TimeRangesOutsideOfRayTimesCommit) {
  const float times[] = {-3, -1, -1e-5f, 0, 1e-5f, 0.5f, 0.99995f, 1, 1.00001f, 1.5f, 2};
  size_t commits = 0;
  for (const char* config : {"", "subdiv_accel=cbvh"}) {
    Device device(config);
    const bool isCompressed = *config != 0;
    Random random(seed + 7);
    const std::vector<RTCRayHit> rays = raysAt(random, 200);
    for (Size size : {Size::Primitive, Size::Block, Size::Many})
      for (size_t b = 0; b < std::size(times); b++)
        for (size_t e = b + 1; e < std::size(times); e++)
          for (const auto& [name, geometry] : movingSurfaces(device, size, times[b], times[e])) {
            SCOPED_TRACE(testing::Message() << name << ", size " << int(size) << ", from " << times[b] << " to "
                                            << times[e] << ", " << config);
            Scene scene(device);
            attach(scene, geometry);
            rtcCommitScene(scene);
            ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
            commits++;
            if (times[e] > 0 && times[b] < 1) continue;
            for (float time : {0.0f, 0.25f, 0.75f, 1.0f}) {
              size_t hits = 0;
              for (RTCRayHit ray : rays) {
                ray.ray.time = time;
                hits += isHit(intersect(scene, ray));
              }
              // Embree's kernels leave out such geometry; small meshes are left to Embree
              const bool isVisible =
                  isCompressed && (times[b] == time || times[e] == time) && (size != Size::Primitive || name == "cage");
              ASSERT_EQ(hits > 0, isVisible) << "time " << time;
            }
          }
  }
  EXPECT_EQ(commits, 2u * 3 * 55 * 4);
}

// Consecutive surfaces. The builder splits time until some parts contain no surface.
TEST(MovingHardCases, SurfacesAreHitOnlyInTheirTimeRange) {
  const unsigned parts = 6;
  for (const char* config : {"", "subdiv_accel=cbvh"})
    for (Size size : {Size::Primitive, Size::Block, Size::Many}) {
      Device device(config);
      Scene scene(device);
      std::vector<std::pair<float, float>> ranges;
      for (unsigned i = 0; i < parts; i++) {
        const float begin = float(i) / parts, end = begin + 0.5f / parts;
        for (const auto& [name, geometry] : movingSurfaces(device, size, begin, end, 9)) {
          attach(scene, geometry);
          ranges.push_back({begin, end});
        }
      }
      rtcCommitScene(scene);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      Random random(seed + 9);
      size_t hits = 0;
      for (RTCRayHit ray : raysAt(random, 2000)) {
        ray.ray.time = float(random.uniform(0, 1));
        const RTCRayHit hit = intersect(scene, ray);
        if (!isHit(hit)) continue;
        hits++;
        const auto& [begin, end] = ranges[hit.hit.geomID];
        ASSERT_TRUE(ray.ray.time >= begin - 1e-4f && ray.ray.time <= end + 1e-4f)
            << "time " << ray.ray.time << ", geometry " << hit.hit.geomID << ", " << config;
      }
      EXPECT_GT(hits, 50u) << int(size) << ", " << config;
    }
}

// Surfaces that exist only after the times of all rays, next to others.
TEST(MovingHardCases, SurfaceOutsideOfRayTimesDoesNotHideOthers) {
  for (const char* config : {"", "subdiv_accel=cbvh"}) {
    Device device(config);
    Random places(seed + 8);
    const std::vector<RTCRayHit> rays = raysAt(places, 400);
    const auto trace = [&](bool hasOther) {
      Random random(1);
      Scene scene(device);
      for (const auto& [name, geometry] : movingSurfaces(device, Size::Many, 0, 1)) attach(scene, geometry);
      if (hasOther)
        for (Size size : {Size::Primitive, Size::Block})
          for (const auto& [name, geometry] : movingSurfaces(device, size, 1.25f, 2)) attach(scene, geometry);
      rtcCommitScene(scene);
      std::vector<RTCRayHit> hits;
      for (RTCRayHit ray : rays) {
        ray.ray.time = float(random.uniform(0, 1));
        hits.push_back(intersect(scene, ray));
      }
      return hits;
    };
    const std::vector<RTCRayHit> alone = trace(false);
    const std::vector<RTCRayHit> beside = trace(true);
    size_t hits = 0;
    for (size_t i = 0; i < rays.size(); i++) {
      hits += isHit(alone[i]);
      ASSERT_EQ(alone[i].ray.tfar, beside[i].ray.tfar);
      ASSERT_EQ(alone[i].hit.geomID, beside[i].hit.geomID);
    }
    EXPECT_GT(hits, 100u);
  }
}

TEST(MovingHardCases, EmptySurfacesHaveEmptyBounds) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const DicedMotion motion = [=](const Vec& p, unsigned) { return Vec{p[0], nan, p[2]}; };
  for (const char* config : {"", "subdiv_accel=cbvh"}) {
    Device device(config);
    Random random(3);
    Diced grids = dicedSheet(4, 16);
    DicedMesh mesh = meshOf(grids, QuadOrder::Rows, random);
    grids.motion = mesh.motion = motion;
    SurfaceSettings settings;
    settings.timeSteps = 2;
    settings.motion = motion;
    for (RTCGeometry geometry :
         {newSurface(device, cubeCage(), settings), newGrids(device, grids, RTC_COMPRESSION_INHERIT, 0, 2),
          newMesh(device, mesh, RTC_COMPRESSION_INHERIT, 0, 2),
          newMesh(device, trianglesOf(mesh), RTC_COMPRESSION_INHERIT, 0, 2)}) {
      Scene scene(device);
      attach(scene, geometry);
      rtcCommitScene(scene);
      RTCBounds bounds;
      rtcGetSceneBounds(scene, &bounds);
      EXPECT_TRUE(bounds.lower_x > bounds.upper_x && bounds.lower_y > bounds.upper_y && bounds.lower_z > bounds.upper_z)
          << config << ": " << bounds.lower_x << " to " << bounds.upper_x << ", " << bounds.lower_y << " to "
          << bounds.upper_y << ", " << bounds.lower_z << " to " << bounds.upper_z;
    }
  }
}

}} // namespace programs::test
