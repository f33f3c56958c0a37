// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Faces of cLEAF that leaves represent badly are stored as cVERT: which faces these are, that this fixes their errors,
 * and that no gaps open between both forms. */

#include "support/edge_rates.h"
#include "support/message_parts.h"
#include "support/scene_blocks.h"
#include "support/vert_triangles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>

namespace programs::test { namespace {

SurfaceSettings leaf(float rate, bool fallbackFaces) {
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CLEAF;
  settings.fallbackFaces = fallbackFaces;
  settings.rate = rate;
  return settings;
}

// Rays at a surface around the origin.
struct Hits {
  unsigned grid = 0, wrong = 0, flipped = 0; // wrong: hits where GRID misses, or the reverse

  Hits(RTCScene gridScene, RTCScene scene, unsigned count) {
    Random random(31);
    for (const RTCRayHit& ray : raysAt(random, count)) {
      const RTCRayHit g = intersect(gridScene, ray), s = intersect(scene, ray);
      grid += isHit(g);
      wrong += isHit(g) != isHit(s);
      const float size = std::fabs(g.ray.tfar) * 1e-2f;
      if (isHit(g) && isHit(s) && std::fabs(g.ray.tfar - s.ray.tfar) < size)
        flipped += g.hit.Ng_x * s.hit.Ng_x + g.hit.Ng_y * s.hit.Ng_y + g.hit.Ng_z * s.hit.Ng_z < 0;
    }
  }
};

Cage openSheet() {
  Cage cage;
  // a single face is a disc: its smooth boundary is one curve
  cage.positions = {{-1.5f, -1.5f, 0}, {1.5f, -1.5f, 0}, {1.5f, 1.5f, 0.3f}, {-1.5f, 1.5f, 0}};
  cage.addFace({0, 1, 2, 3});
  return cage;
}

TEST(FallbackFaces, CurvedBordersMatchGrid) {
  Device device;
  for (float rate : {4.0f, 16.0f, 64.0f}) {
    SCOPED_TRACE(rate);
    const Twins leaves(device, openSheet(), leaf(rate, false)), mixed(device, openSheet(), leaf(rate, true));
    EXPECT_EQ(statisticsOf(leaves.scene).numFallbackQuads, 0u);
    EXPECT_EQ(statisticsOf(mixed.scene).numFallbackQuads, size_t(rate * rate));
    const Hits before(leaves.grid, leaves.scene, 40000), after(mixed.grid, mixed.scene, 40000);
    ASSERT_GT(after.grid, 10000u);
    EXPECT_LE(after.wrong, after.grid / 1000 + 2);
    EXPECT_GT(before.wrong, 2 * after.wrong);
  }
}

TEST(FallbackFaces, WallsFaceTheRightWay) {
  // cliffs: some quads are nearly parallel to the sheet's normal
  struct Cliff : public Displacement {
    static void apply(const RTCDisplacementFunctionNArguments* args) {
      for (unsigned i = 0; i < args->N; i++) {
        const float x = args->P_x[i];
        args->P_z[i] += 0.8f * std::tanh(30 * std::sin(6 * x));
        args->P_x[i] += 0.06f * std::sin(12 * x); // overhangs
      }
    }
  } cliff;
  Device device;
  const auto build = [&](RTCScene scene, SurfaceSettings settings) {
    RTCGeometry geometry = newSurface(device, sheetCage(2), settings);
    rtcSetGeometryDisplacementFunction(geometry, Cliff::apply);
    rtcCommitGeometry(geometry);
    attach(scene, geometry);
    rtcCommitScene(scene);
  };
  Scene grid(device), leaves(device), mixed(device);
  SurfaceSettings none = leaf(32, false);
  none.compression = RTC_COMPRESSION_NONE;
  build(grid, none);
  build(leaves, leaf(32, false));
  build(mixed, leaf(32, true));
  const RTCCompressionStatistics before = statisticsOf(leaves), after = statisticsOf(mixed);
  EXPECT_GT(before.numFlippedQuads, 10u);
  EXPECT_LT(after.numFlippedQuads, before.numFlippedQuads / 10);
  EXPECT_GT(after.numFallbackQuads, 0u);
  const Hits leafHits(grid, leaves, 40000), mixedHits(grid, mixed, 40000);
  EXPECT_GT(leafHits.flipped, 10 * mixedHits.flipped + 10);
}

TEST(FallbackFaces, SmoothFacesStayLeaves) {
  Device device;
  Displacement displacement;
  displacement.amplitude = 0.01f;
  SurfaceSettings settings = leaf(64, true);
  settings.displacement = &displacement;
  const SurfaceScene scene(device, cubeCage(), settings);
  EXPECT_EQ(statisticsOf(scene).numFallbackQuads, 0u);
}

// One face of 4 x 4 blocks with folds at two vertices of four blocks, of the quarter that is encoded first or of
// others.
struct FewFolds : public Displacement {
  bool inFirstQuarter = false;

  static void apply(const RTCDisplacementFunctionNArguments* args) {
    const FewFolds& folds = *static_cast<FewFolds*>((Displacement*)args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; i++) {
      const long x = std::lround(64 * args->u[i]), y = std::lround(64 * args->v[i]);
      const bool inBlock = folds.inFirstQuarter ? x / 16 == y / 16 : x / 16 + y / 16 == 3;
      if (args->primID != 0 || !inBlock || x % 16 != y % 16 || (x % 16 != 5 && x % 16 != 11)) continue;
      // moves two or three quads sideways
      args->P_x[i] += 0.06f * (args->Ng_y[i] - args->Ng_z[i]);
      args->P_y[i] += 0.06f * (args->Ng_z[i] - args->Ng_x[i]);
      args->P_z[i] += 0.06f * (args->Ng_x[i] - args->Ng_y[i]);
    }
  }
};

// Four quads at each of eight vertices are less than 1/64 of 4096 quads, but more than 1/64 of a quarter.
TEST(FallbackFaces, FirstQuarterOfPatchDoesNotDecideAlone) {
  Device device;
  FewFolds displacement;
  SurfaceSettings settings = leaf(64, true);
  settings.displacement = &displacement;
  for (bool inFirstQuarter : {false, true}) {
    SCOPED_TRACE(inFirstQuarter);
    displacement.inFirstQuarter = inFirstQuarter;
    Scene scene(device);
    RTCGeometry geometry = newSurface(device, cubeCage(), settings);
    rtcSetGeometryDisplacementFunction(geometry, FewFolds::apply);
    attach(scene, geometry);
    rtcCommitScene(scene);
    EXPECT_EQ(statisticsOf(scene).numFallbackQuads, inFirstQuarter ? 4096u : 0u);
  }
}

struct PartlyRough : public Displacement {
  static void apply(const RTCDisplacementFunctionNArguments* args) {
    for (unsigned i = 0; i < args->N; i++) {
      const float x = args->P_x[i], y = args->P_y[i], z = args->P_z[i];
      const float rough = x > 0.1f ? std::min(1.0f, 4 * (x - 0.1f)) : 0;
      args->P_x[i] += 0.05f * std::sin(5 * y) * std::cos(3 * z) + 0.12f * rough * std::sin(31 * y + 17 * z);
      args->P_y[i] += 0.12f * rough * std::sin(29 * z + 13 * x);
      args->P_z[i] += 0.12f * rough * std::sin(37 * x + 11 * y);
    }
  }
};

// Rays from inside a closed surface at vertices of fallback faces, and at random.
TEST(FallbackFaces, NoGapsBetweenBothForms) {
  Device device;
  for (const auto& cage : closedCages)
    for (bool mixedRates : {false, true}) {
      SCOPED_TRACE(testing::Message() << cage.name << (mixedRates ? ", mixed rates" : ""));
      SurfaceSettings settings = leaf(32, true);
      if (mixedRates) {
        Random random(7);
        settings.edgeRates = drawRates(cage.cage, random, rateSets[1].draw);
      }
      const auto build = [&](RTCScene scene) {
        RTCGeometry geometry = newSurface(device, cage.cage, settings);
        rtcSetGeometryDisplacementFunction(geometry, PartlyRough::apply);
        rtcCommitGeometry(geometry);
        attach(scene, geometry);
        rtcCommitScene(scene);
      };
      Scene scene(device), grid(device);
      build(scene);
      settings.compression = RTC_COMPRESSION_NONE;
      build(grid);
      const RTCCompressionStatistics stats = statisticsOf(scene);
      EXPECT_GT(stats.numFallbackQuads, 0u);
      if (!mixedRates) { EXPECT_LT(stats.numFallbackQuads, stats.numQuads); }
      std::vector<Vec> targets;
      for (const VertTriangle& t : vertTriangles(scene)) targets.push_back(t.vertices[0]);
      ASSERT_FALSE(targets.empty());
      Random random(17);
      unsigned missed = 0, missedAny = 0, missedInGrid = 0;
      const unsigned count = 60000;
      for (unsigned i = 0; i < count; i++) {
        // the origin is deep inside all of these cages
        const Vec o = {float(random.uniform(-0.02, 0.02)), float(random.uniform(-0.02, 0.02)),
                       float(random.uniform(-0.02, 0.02))};
        Vec d;
        if (i % 4) {
          const Vec& target = targets[random.below(unsigned(targets.size()))];
          for (int k = 0; k < 3; k++) d[k] = target[k] - o[k];
        } else
          for (int k = 0; k < 3; k++) d[k] = float(random.normal());
        const RTCRayHit ray = makeRay(o, d);
        missed += !isHit(intersect(scene, ray));
        missedAny += !occluded(scene, ray);
        missedInGrid += i % 4 == 0 && !isHit(intersect(grid, ray));
      }
      EXPECT_EQ(missed, 0u);
      EXPECT_EQ(missedAny, 0u);
      EXPECT_EQ(missedInGrid, 0u) << "the surface is not closed";
    }
}

size_t fallbackQuads(const std::string& config) {
  Device device(config);
  if (!device) return ~size_t(0);
  SurfaceSettings settings;
  settings.rate = 16;
  const SurfaceScene scene(device, openSheet(), settings);
  return statisticsOf(scene).numFallbackQuads;
}

TEST(FallbackFaces, GeometryOverridesDeviceOverridesEnvironment) {
  EXPECT_EQ(fallbackQuads("subdiv_accel=cbvh.leaf"), 256u);
  EXPECT_EQ(fallbackQuads("subdiv_accel=cbvh.leaf,cbvh_fallback_faces=0"), 0u);
  EXPECT_EQ(fallbackQuads("subdiv_accel=cbvh.leaf,cbvh_fallback_faces=1"), 256u);
  EXPECT_EQ(fallbackQuads("subdiv_accel=cbvh.voxel,cbvh_fallback_faces=1"), 0u);
  setenv("EMBREE_CBVH", "leaf,fallback_faces=0", 1);
  EXPECT_EQ(fallbackQuads(""), 0u);
  EXPECT_EQ(fallbackQuads("cbvh_fallback_faces=1"), 256u);
  unsetenv("EMBREE_CBVH");
  Device device("subdiv_accel=cbvh.leaf,cbvh_fallback_faces=0");
  const SurfaceScene scene(device, openSheet(), leaf(16, true));
  EXPECT_EQ(statisticsOf(scene).numFallbackQuads, 256u);
  Device other("subdiv_accel=cbvh.leaf,cbvh_fallback_faces=1");
  const SurfaceScene leaves(other, openSheet(), leaf(16, false));
  EXPECT_EQ(statisticsOf(leaves).numFallbackQuads, 0u);
}

TEST(FallbackFaces, OtherValuesAreErrors) {
  for (const char* config : {"cbvh_fallback_faces=2", "cbvh_fallback_faces=yes", "cbvh_fallback_faces"})
    EXPECT_EQ(fallbackQuads(config), ~size_t(0)) << config;
  Device device;
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.fallbackFaces = 2;
  rtcSetGeometryCompression(geometry, &args);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"fallbackFaces", " 2"}));
  rtcReleaseGeometry(geometry);
}

}} // namespace programs::test
