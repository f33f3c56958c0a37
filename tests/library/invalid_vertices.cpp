// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Displacement functions that return NaN or infinity, and control vertices that are not finite: the quads around such
 * vertices are left out, counted and reported as an error; everything else is unchanged. */

#include "support/message_parts.h"
#include "support/random.h"
#include "support/scene.h"
#include "support/scene_blocks.h"

#include <algorithm>
#include <thread>

namespace programs::test { namespace {

class InvalidVertices : public testing::TestWithParam<RTCCompression> {};

std::string nameOf(const testing::TestParamInfo<RTCCompression>& info) { return kindName(info.param); }
INSTANTIATE_TEST_SUITE_P(Compression, InvalidVertices,
                         testing::Values(RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
                                         RTC_COMPRESSION_CVERT),
                         nameOf);

constexpr int quads = 16;

int lattice(float u) { return int(std::lround(u * quads)); }

TEST_P(InvalidVertices, OnlyTheirQuadsAreLeftOut) {
  RecordProperty(
      "property",
      "quads with a vertex that is NaN or infinite are left out and counted, and no others: inside a block, on borders "
      "of blocks, on the rim");
  Device device;
  // vertex (x, y) of the grid is invalid: inside a block, on the border of two blocks, on a corner of four blocks, on
  // the rim
  const std::vector<std::vector<std::array<int, 2>>> sets = {{{6, 6}},
                                                             {{4, 6}},
                                                             {{8, 8}},
                                                             {{0, 5}},
                                                             {{0, 0}},
                                                             {{3, 3}, {4, 3}, {13, 2}, {16, 16}},
                                                             {{7, 9}, {7, 10}, {7, 11}, {8, 12}}};
  for (size_t set = 0; set < sets.size(); set++)
    for (int frameLevel : {0, 1, 2, 4}) {
      SCOPED_TRACE(testing::Message() << "set " << set << ", frame level " << frameLevel);
      auto isBad = [&](int x, int y) {
        for (const auto& p : sets[set])
          if (p[0] == x && p[1] == y) return true;
        return false;
      };
      auto isBadQuad = [&](int x, int y) {
        return isBad(x, y) || isBad(x + 1, y) || isBad(x, y + 1) || isBad(x + 1, y + 1);
      };
      size_t invalid = 0;
      for (int y = 0; y < quads; y++)
        for (int x = 0; x < quads; x++) invalid += isBadQuad(x, y);

      Displacement displacement;
      displacement.amplitude = 0.01f;
      displacement.poison = [&](unsigned, float u, float v) { return isBad(lattice(u), lattice(v)); };
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.rate = quads;
      settings.compression = GetParam();
      settings.frameLevel = frameLevel;
      const SurfaceScene scene(device, quadCage(), settings);
      ASSERT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
      EXPECT_TRUE(containsInOrder(
          device.message, {"geometry 0, face 0:", "finite", " 1 face", " " + std::to_string(invalid) + " quads"}));
      EXPECT_EQ(statisticsOf(scene).numInvalidQuads, invalid);
      RTCBounds bounds;
      rtcGetSceneBounds(scene, &bounds);
      EXPECT_TRUE(std::isfinite(bounds.lower_x) && std::isfinite(bounds.upper_z));

      const bool hasVertices = GetParam() == RTC_COMPRESSION_CGRID || GetParam() == RTC_COMPRESSION_CVERT;
      // Rays straight down at the first triangle of each quad. Quads next to a hole may extend into it by a leaf's
      // overlap or thickness.
      for (int y = 0; y < quads; y++)
        for (int x = 0; x < quads; x++) {
          const float u = (x + 0.3f) / quads, v = (y + 0.3f) / quads;
          const RTCRayHit ray = makeRay({u, v, 1}, {0, 0, -1});
          const RTCRayHit hit = intersect(scene, ray);
          ASSERT_EQ(occluded(scene, ray), isHit(hit));
          if (!isBadQuad(x, y)) { ASSERT_TRUE(isHit(hit)) << "quad " << x << ", " << y; }
          // cGRID and cVERT have vertices: the other triangle of a quad may be visible, as in GRID
          const bool badTriangle = isBad(x, y) || isBad(x + 1, y) || isBad(x, y + 1);
          if (badTriangle && hasVertices) { ASSERT_FALSE(isHit(hit)) << "quad " << x << ", " << y; }
          if (!isHit(hit)) continue;
          ASSERT_TRUE(std::isfinite(hit.ray.tfar) && std::isfinite(hit.hit.Ng_x + hit.hit.Ng_y + hit.hit.Ng_z));
          ASSERT_NEAR(hit.ray.tfar, 1, 0.1f);
          const int i = int(hit.hit.u * quads), j = int(hit.hit.v * quads);
          if (hasVertices) continue;
          ASSERT_FALSE(isBadQuad(std::min(i, quads - 1), std::min(j, quads - 1)) &&
                       std::fabs(hit.hit.u * quads - i - 0.5f) < 0.49f &&
                       std::fabs(hit.hit.v * quads - j - 0.5f) < 0.49f)
              << "hit in a quad that is left out";
        }
    }
}

TEST_P(InvalidVertices, HolesStayOpen) {
  RecordProperty("property", "a hole of quads that are left out stays open");
  // a hole of 6 x 6 quads is wider than any overlap
  Device device;
  Displacement displacement;
  displacement.amplitude = 0.01f;
  displacement.poison = [](unsigned, float u, float v) {
    const int x = lattice(u), y = lattice(v);
    return x >= 5 && x <= 9 && y >= 5 && y <= 9;
  };
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = quads;
  settings.compression = GetParam();
  settings.frameLevel = 0;
  const SurfaceScene scene(device, quadCage(), settings);
  EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 36u);
  EXPECT_FALSE(isHit(intersect(scene, makeRay({7.0f / quads, 7.0f / quads, 1}, {0, 0, -1}))));
  EXPECT_TRUE(isHit(intersect(scene, makeRay({2.0f / quads, 7.0f / quads, 1}, {0, 0, -1}))));
}

// cVOXEL stores patches with holes as cLEAF: the same bytes, including frames.
TEST(VoxelsWithHoles, MatchBlocksOfLeaves) {
  Device device;
  Displacement displacement;
  displacement.amplitude = 0.1f;
  displacement.poison = [](unsigned, float u, float v) { return lattice(u) == 3 && lattice(v) == 6; };
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = quads;
  settings.frameLevel = 1;
  std::vector<std::string> blocks[2];
  for (int i = 0; i < 2; i++) {
    settings.compression = i ? RTC_COMPRESSION_CLEAF : RTC_COMPRESSION_CVOXEL;
    const SurfaceScene scene(device, quadCage(), settings);
    for (const embree::cbvh::Block* block : sceneBlocks(scene))
      blocks[i].emplace_back((const char*)block, block->layout().bytes);
    std::sort(blocks[i].begin(), blocks[i].end());
  }
  EXPECT_EQ(blocks[0].size(), 4u);
  EXPECT_EQ(blocks[0], blocks[1]);
}

TEST_P(InvalidVertices, SceneOfOnlyInvalidVerticesIsEmpty) {
  RecordProperty("property", "a scene of nothing but vertices that are not finite is empty, and tracing it ends");
  Device device;
  Displacement displacement;
  displacement.poison = [](unsigned, float, float) { return true; };
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = GetParam();
  const SurfaceScene scene(device, cubeCage(), settings);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 6u * 16 * 16);
  EXPECT_EQ(statisticsOf(scene).numBlocks, 0u);
  EXPECT_FALSE(isHit(intersect(scene, makeRay({0, 0, 5}, {0, 0, -1}))));
  EXPECT_FALSE(occluded(scene, makeRay({0, 0, 5}, {0, 0, -1})));
}

TEST_P(InvalidVertices, FacesNextToInvalidOnesAreComplete) {
  RecordProperty("property", "faces next to one whose vertices are not finite are complete");
  Device device;
  Displacement displacement;
  displacement.poison = [](unsigned primID, float, float) { return primID == 2; };
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = GetParam();
  settings.frameLevel = 2;
  const SurfaceScene scene(device, cubeCage(), settings);
  EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 16u * 16);
  EXPECT_EQ(statisticsOf(scene).numBlocks, GetParam() == RTC_COMPRESSION_CVERT ? 5u : 5u * 16);
  Random random(71);
  for (int i = 0; i < 2000; i++) { // from the center: all sides except for -y
    Vec d = {float(random.uniform(-1, 1)), float(random.uniform(-0.5, 1)), float(random.uniform(-1, 1))};
    if (d[1] < 0 && std::fabs(d[1]) > 0.5f * std::max(std::fabs(d[0]), std::fabs(d[2]))) continue;
    ASSERT_TRUE(isHit(intersect(scene, makeRay({0, 0, 0}, d))));
  }
}

TEST_P(InvalidVertices, AreReportedOnceWithGeometryAndFace) {
  RecordProperty("property", "vertices that are not finite are an error of the device, once, with geometry and face");
  Device device;
  Displacement sound, bad, worse;
  bad.poison = [](unsigned primID, float u, float v) { return primID >= 3 && u == 0 && v == 0; };
  worse.poison = [](unsigned primID, float, float) { return primID == 1; };
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  RTCGeometry geometries[3];
  int i = 0;
  for (Displacement* displacement : {&sound, &bad, &worse}) {
    SurfaceSettings settings;
    settings.displacement = displacement;
    settings.compression = GetParam();
    rtcAttachGeometry(scene, geometries[i++] = newSurface(device, cubeCage(), settings));
  }
  std::vector<std::string> messages;
  rtcSetDeviceErrorFunction(
      device, [](void* list, RTCError, const char* text) { ((std::vector<std::string>*)list)->push_back(text); },
      &messages);
  auto commit = [&]() {
    messages.clear();
    rtcCommitScene(scene);
    return rtcGetDeviceError(device);
  };
  const std::vector<std::string> ofBad = {"geometry 1, face 3:", "finite", " 3 face", " 3 quads"};
  EXPECT_EQ(commit(), RTC_ERROR_INVALID_ARGUMENT);
  ASSERT_EQ(messages.size(), 2u);
  EXPECT_TRUE(containsInOrder(messages[0], ofBad));
  EXPECT_TRUE(containsInOrder(messages[1], {"geometry 2, face 1:", "finite", " 1 face", " 256 quads"}));
  EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 259u);

  EXPECT_EQ(commit(), RTC_ERROR_NONE) << "nothing changed";
  rtcCommitGeometry(geometries[0]);
  EXPECT_EQ(commit(), RTC_ERROR_NONE) << "only a valid geometry changed";
  EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 259u);
  rtcCommitGeometry(geometries[1]);
  EXPECT_EQ(commit(), RTC_ERROR_INVALID_ARGUMENT);
  ASSERT_EQ(messages.size(), 1u);
  EXPECT_TRUE(containsInOrder(messages[0], ofBad));
  for (RTCGeometry geometry : geometries) rtcReleaseGeometry(geometry);
}

// Except in cVERT, GRID traces such faces.
TEST_P(InvalidVertices, AreReportedAtEdgeRatesAbove256) {
  Device device;
  Displacement displacement;
  displacement.poison = [](unsigned, float u, float v) { // in the middle
    return std::fabs(u - 0.5f) < 1e-3f && std::fabs(v - 0.5f) < 1e-3f;
  };
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = GetParam();
  settings.edgeRates = {300, 4, 300, 4};
  const SurfaceScene scene(device, quadCage(), settings);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"geometry 0, face 0:", "finite", " 1 face", " 4 quads"}));
  EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 4u);
}

// A canceled commit reports nothing.
TEST_P(InvalidVertices, AreReportedOnceAfterACanceledCommit) {
  RecordProperty("property", "vertices that are not finite are an error once, also after a commit that was canceled");
  Device device("threads=1");
  Displacement bad, sound;
  bad.poison = [](unsigned primID, float u, float v) { return primID == 3 && u == 0 && v == 0; };
  SurfaceSettings settings;
  settings.compression = GetParam();
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  for (Displacement* displacement : {&bad, &sound}) {
    settings.displacement = displacement;
    addSurface(device, scene, cubeCage(), settings);
  }
  using Errors = std::vector<std::pair<RTCError, std::string>>;
  Errors errors;
  rtcSetDeviceErrorFunction(
      device, [](void* list, RTCError code, const char* text) { ((Errors*)list)->emplace_back(code, text); }, &errors);
  double cancelAt = 0.6; // in the second surface
  rtcSetSceneProgressMonitorFunction(scene, [](void* at, double n) { return n < *(double*)at; }, &cancelAt);
  rtcCommitScene(scene);
  EXPECT_EQ(rtcGetDeviceError(device), RTC_ERROR_CANCELLED);
  for (const auto& [code, message] : errors) EXPECT_EQ(code, RTC_ERROR_CANCELLED) << message;
  errors.clear();
  cancelAt = 2;
  rtcCommitScene(scene);
  EXPECT_EQ(rtcGetDeviceError(device), RTC_ERROR_INVALID_ARGUMENT);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_TRUE(containsInOrder(errors[0].second, {"geometry 0, face 3:", "finite", " 1 face", " 1 quad"}));
}

TEST_P(InvalidVertices, AreReportedToOneOfTheThreadsThatJoinACommit) {
  RecordProperty("property", "vertices that are not finite are an error on one of the threads that join a commit");
  Device device;
  Displacement displacement;
  displacement.poison = [](unsigned primID, float, float) { return primID == 4; };
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = GetParam();
  Scene scene(device);
  addSurface(device, scene, cubeCage(), settings);
  unsigned reported[4] = {};
  std::vector<std::thread> threads;
  for (unsigned& n : reported)
    threads.emplace_back([&]() {
      rtcJoinCommitScene(scene);
      n = rtcGetDeviceError(device) == RTC_ERROR_INVALID_ARGUMENT;
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(reported[0] + reported[1] + reported[2] + reported[3], 1u);
  EXPECT_EQ(device.errors, 1u);
}

// A needle has no usable frame, and GRID, which traces such blocks, does not support holes.
TEST_P(InvalidVertices, ValidQuadsOfBlocksWithoutFrameAreKept) {
  RecordProperty("property", "a block without a usable frame keeps its finite quads");
  const float width = 1e-5f;
  Cage needle = quadCage();
  for (Vec& p : needle.positions) p[1] *= width;
  Displacement displacement;
  displacement.amplitude = 0;
  displacement.poison = [](unsigned, float u, float v) { return lattice(u) == 9 && lattice(v) == 5; };
  for (int frameLevel : {0, 2}) {
    Device device;
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.rate = quads;
    settings.compression = GetParam();
    settings.frameLevel = frameLevel;
    const SurfaceScene scene(device, needle, settings);
    EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 4u);
    for (int y = 0; y < quads; y++)
      for (int x = 0; x < quads; x++) {
        const float u = (x + 0.3f) / quads, v = (y + 0.3f) / quads;
        const RTCRayHit hit = intersect(scene, makeRay({u, v * width, 1}, {0, 0, -1}));
        if (x == 8 && y == 4) continue; // its first triangle is valid and may be visible
        if ((x == 8 || x == 9) && (y == 4 || y == 5)) {
          EXPECT_FALSE(isHit(hit)) << "quad " << x << ", " << y;
          continue;
        }
        ASSERT_TRUE(isHit(hit)) << "quad " << x << ", " << y;
        EXPECT_NEAR(hit.ray.tfar, 1, 1e-5f);
        EXPECT_NEAR(hit.hit.u, u, 1e-4f) << "quad " << x << ", " << y;
        EXPECT_NEAR(hit.hit.v, v, 1e-2f) << "quad " << x << ", " << y;
      }
  }
}

// The surface of a face depends on the vertices of all faces around its corners.
TEST_P(InvalidVertices, ControlVerticesAreCountedAndNamed) {
  RecordProperty("property", "faces that a control vertex which is not finite leaves without surface are counted and "
                             "reported with the vertex, and no others are left out");
  const unsigned side = 8, bad = 3 * (side + 1) + 4; // faces 1 to 4 along v, and 2 to 5 along u, depend on the vertex
  for (float value : notFinite)
    for (unsigned timeSteps : {1u, 2u}) {
      if (timeSteps > 1 && GetParam() != RTC_COMPRESSION_CVERT) continue;
      SCOPED_TRACE(testing::Message() << value << ", " << timeSteps << " time steps");
      Device device;
      Cage cage = sheetCage(side);
      cage.positions[bad][1] = value;
      SurfaceSettings settings;
      settings.rate = quads;
      settings.compression = GetParam();
      settings.timeSteps = timeSteps;
      testing::internal::CaptureStderr();
      const SurfaceScene scene(device, cage, settings);
      const std::string text = testing::internal::GetCapturedStderr();
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << "Embree skips such faces silently: " << device.message;
      EXPECT_TRUE(containsInOrder(text, {"geometry 0, face 10:", " vertex " + std::to_string(bad) + " ", "finite",
                                         " 16 face", " 4096 quads\n"}))
          << text;
      const RTCCompressionStatistics statistics = statisticsOf(scene);
      EXPECT_EQ(statistics.numInvalidQuads, 16u * quads * quads);
      EXPECT_EQ(statistics.numQuads, (side * side - 16u) * quads * quads);
      EXPECT_EQ(statistics.firstInvalidGeomID, 0u);
      EXPECT_EQ(statistics.firstInvalidPrimID, 10u);
      for (unsigned y = 0; y < side; y++)
        for (unsigned x = 0; x < side; x++) {
          const bool isLeftOut = x >= 2 && x < 6 && y >= 1 && y < 5;
          const Vec center = {(2 * x + 1) / float(side) - 0.99f, (2 * y + 1) / float(side) - 0.99f, 5};
          ASSERT_EQ(isHit(intersect(scene, makeRay(center, {0, 0, -1}))), !isLeftOut) << "face " << x << ", " << y;
        }
    }
}

TEST_P(InvalidVertices, HolesAndUnsupportedFacesAreNotCounted) {
  Device device;
  Cage cage = sheetCage(8);
  cage.positions[31][2] = NAN;
  cage.holes = {10, 11, 12, 13, 18};
  SurfaceSettings settings;
  settings.rate = 4;
  settings.compression = GetParam();
  testing::internal::CaptureStderr();
  EXPECT_EQ(statisticsOf(SurfaceScene(device, cage, settings)).numInvalidQuads, 11u * 16);
  const std::string text = testing::internal::GetCapturedStderr();
  EXPECT_TRUE(containsInOrder(text, {"face 19:", " vertex 31 "})) << text;
  cage = sheetCage(8);
  cage.mode = RTC_SUBDIVISION_MODE_NO_BOUNDARY; // Embree leaves out the faces at the border
  const SurfaceScene scene(device, cage, settings);
  EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 0u);
  EXPECT_EQ(statisticsOf(scene).firstInvalidGeomID, 0u);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST_P(InvalidVertices, HugeCoordinatesAreSupportedOrLeftOut) {
  RecordProperty("property", "coordinates up to 1e37 are supported or left out: no crash, and hits up to 1e15");
  Device device;
  for (float scale : {1e10f, 1e15f, 1e18f, 1e25f, 1e30f, 1e37f}) {
    Displacement displacement;
    displacement.scale = scale;
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.rate = 8;
    settings.compression = GetParam();
    const SurfaceScene scene(device, cubeCage(), settings);
    device.takeError();
    const RTCRayHit hit = intersect(scene, makeRay({0, 0, 0}, {0.1f, 0.2f, 1}));
    if (scale <= 1e15f) { EXPECT_TRUE(isHit(hit)) << scale; }
  }
}

}} // namespace programs::test
