// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Buffers that a geometry releases when it is compressed, if a setting requests it, and buffers that stay. */

#include "support/diced_mesh.h"
#include "support/environment.h"
#include "support/memory.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <iterator>
#include <memory>

namespace programs::test { namespace {

// The same sheet as a cage, grids, quads and triangles.
std::vector<RTCGeometry> sheetsOfAllTypes(RTCDevice device) {
  Random random(1);
  const Diced grids = dicedSheet(4, 32);
  const DicedMesh mesh = meshOf(grids, QuadOrder::Rows, random);
  SurfaceSettings settings;
  settings.rate = 32;
  return {newSurface(device, sheetCage(8), settings), newGrids(device, grids), newMesh(device, mesh),
          newMesh(device, trianglesOf(mesh))};
}

// For programs that cannot be changed: later accesses to buffers are errors.
TEST(ReleaseInput, IsASettingOfDeviceAndEnvironment) {
  for (bool byEnvironment : {true, false}) {
    std::unique_ptr<Environment> set(byEnvironment ? new Environment("vert, release_input") : nullptr);
    Memory memory;
    Device device(byEnvironment ? "" : "subdiv_accel=cbvh,cbvh_release_input=1");
    ASSERT_TRUE(bool(device));
    rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
    Random random(1);
    const Diced grids = dicedSheet(4, 32);
    const DicedMesh mesh = meshOf(grids, QuadOrder::Rows, random);
    SurfaceSettings settings;
    settings.rate = 32;
    const std::pair<RTCBufferType, std::function<RTCGeometry()>> types[] = {
        {RTC_BUFFER_TYPE_FACE, [&] { return newSurface(device, sheetCage(8), settings); }},
        {RTC_BUFFER_TYPE_GRID, [&] { return newGrids(device, grids); }},
        {RTC_BUFFER_TYPE_INDEX, [&] { return newMesh(device, mesh); }},
        {RTC_BUFFER_TYPE_INDEX, [&] { return newMesh(device, trianglesOf(mesh)); }}};
    for (const auto& [indices, make] : types) {
      SCOPED_TRACE(testing::Message() << "buffer type " << indices
                                      << (byEnvironment ? ", environment" : ", device string"));
      const ssize_t before = memory.live;
      RTCGeometry geometry = make();
      Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
      rtcAttachGeometry(scene, geometry);
      rtcCommitScene(scene);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      const RTCCompressionStatistics stats = statisticsOf(scene);
      EXPECT_GT(stats.numQuads, 10000u);
      EXPECT_EQ(stats.inputBytes, 0u);
      EXPECT_LT(double(memory.live - before), (byEnvironment ? 5 : 8) * double(stats.numQuads)); // tiles are larger
      const RTCRayHit down = makeRay({0.3f, 0.2f, 5}, {0, 0, -1});
      EXPECT_TRUE(isHit(intersect(scene, down)));
      // commits without a change, and after changes that do not concern the surface
      rtcCommitGeometry(geometry);
      rtcSetGeometryMask(geometry, 1);
      rtcCommitGeometry(geometry);
      rtcCommitScene(scene);
      EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      EXPECT_TRUE(isHit(intersect(scene, down)));
      for (RTCBufferType type : {RTC_BUFFER_TYPE_VERTEX, indices}) {
        EXPECT_EQ(rtcGetGeometryBufferData(geometry, type, 0), nullptr);
        EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
        EXPECT_NE(device.message.find("release_input"), std::string::npos) << device.message;
      }
      float P[3];
      rtcInterpolate0(geometry, 0, 0.5f, 0.5f, RTC_BUFFER_TYPE_VERTEX, 0, P, 3);
      EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
      rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
      rtcCommitGeometry(geometry);
      EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
      EXPECT_NE(device.message.find("release_input"), std::string::npos) << device.message;
      rtcReleaseGeometry(geometry);
    }
  }
}

// Compression that selects the same blocks is no change: they remain. Any other compression is refused until the input
// is set again. Embree's own setters always count: functions and user data may return other values than before.
TEST(ReleaseInput, RepeatedCompressionIsNoChange) {
  Device device("cbvh_release_input=1");
  SurfaceSettings settings;
  settings.rate = 32;
  settings.compression = RTC_COMPRESSION_CVERT;
  RTCGeometry geometry = newSurface(device, sheetCage(8), settings);
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  const RTCRayHit down = makeRay({0.3f, 0.2f, 5}, {0, 0, -1});
  const auto compress = [&](RTCGeometry g, bool isSame) { // as newSurface()
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = settings.compression;
    args.fallbackFaces = settings.fallbackFaces;
    if (!isSame) args.maxError = 0.125f;
    rtcSetGeometryCompression(g, &args);
  };
  const auto expect = [&](bool isAccepted, const char* what) {
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    EXPECT_EQ(device.takeError() == RTC_ERROR_NONE, isAccepted) << what << ": " << device.message;
    device.takeError();
  };
  for (bool hides : {false, true}) {
    if (hides) rtcSetGeometryMask(geometry, 1); // next to a change that keeps the blocks
    compress(geometry, true);
    expect(true, "the same compression");
    EXPECT_TRUE(isHit(intersect(scene, down)));
  }
  rtcReleaseGeometry(geometry);
  for (const auto& change : std::vector<std::function<void(RTCGeometry)>>{
           [&](RTCGeometry g) { compress(g, false); }, [](RTCGeometry g) { rtcSetGeometryTessellationRate(g, 16); },
           [](RTCGeometry g) { rtcSetGeometryUserData(g, nullptr); },
           [](RTCGeometry g) { rtcSetGeometryDisplacementFunction(g, nullptr); }}) {
    RTCGeometry other = newSurface(device, sheetCage(8), settings);
    change(other);
    geometry = other;
    expect(false, "a change");
    rtcReleaseGeometry(other);
  }
}

// The topology is released, too, if the geometry has no attributes when it is committed.
TEST(ReleaseInput, LaterAttributesCannotBeInterpolated) {
  Device device("subdiv_accel=cbvh,cbvh_release_input=1");
  size_t type = 0;
  for (RTCGeometry geometry : sheetsOfAllTypes(device)) {
    SCOPED_TRACE(type++);
    rtcCommitGeometry(geometry);
    rtcSetGeometryVertexAttributeCount(geometry, 1);
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, RTC_FORMAT_FLOAT3, dicedSheet(4, 32).vertices);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    float P[3] = {-7, -7, -7};
    rtcInterpolate0(geometry, 0, 0.5f, 0.5f, RTC_BUFFER_TYPE_VERTEX_ATTRIBUTE, 0, P, 3);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
    EXPECT_EQ(P[0], -7);
    rtcReleaseGeometry(geometry);
  }
}

// The commit of the geometry builds its blocks, and the progress function commits the geometry again.
TEST(ReleaseInput, CallbacksMustNotCommitTheirGeometry) {
  struct Callback {
    RTCGeometry geometry = nullptr;
    std::atomic<unsigned> calls{0};

    static bool function(void* self, double) {
      Callback& callback = *(Callback*)self;
      if (callback.calls++ == 0) rtcCommitGeometry(callback.geometry);
      return true;
    }
  };
  Device device;
  size_t type = 0;
  for (RTCGeometry geometry : sheetsOfAllTypes(device)) {
    SCOPED_TRACE(type++);
    Callback callback;
    callback.geometry = geometry;
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = RTC_COMPRESSION_CVERT;
    args.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT;
    args.progress = Callback::function;
    args.progressUserPtr = &callback;
    rtcSetGeometryCompression(callback.geometry, &args);
    rtcCommitGeometry(callback.geometry);
    EXPECT_GT(callback.calls, 0u);
    EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
    EXPECT_NE(device.message.find("callback"), std::string::npos) << device.message;
    Scene scene(device);
    attach(scene, callback.geometry);
    rtcCommitScene(scene);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_GT(statisticsOf(scene).numQuads, 10000u);
    EXPECT_TRUE(isHit(intersect(scene, makeRay({0.3f, 0.2f, 5}, {0, 0, -1}))));
  }
}

// Without the setting: each buffer once, except for shared ones.
TEST(ReleaseInput, StatisticsCountRemainingBuffers) {
  Memory memory;
  Device device("subdiv_accel=cbvh");
  rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
  Random random(1);
  const DicedMesh mesh = meshOf(dicedSheet(4, 32), QuadOrder::Rows, random);
  const size_t bytes = sizeof(Vec) * mesh.vertices.size() + 16 * mesh.quads.size();
  Scene scene(device);
  RTCGeometry geometry = newMesh(device, mesh);
  rtcAttachGeometry(scene, geometry);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  EXPECT_NEAR(double(statisticsOf(scene).inputBytes), double(bytes), 32) << "Embree pads its buffers";
  std::vector<Vec> vertices = mesh.vertices;
  vertices.push_back({0, 0, 0});
  rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices.data(), 0, sizeof(Vec),
                             mesh.vertices.size());
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_NEAR(double(statisticsOf(scene).inputBytes), 16 * double(mesh.quads.size()), 16);
  rtcReleaseGeometry(geometry);
}

// 33124 half-edges. Without a reservation, Embree allocates twice as many: a power of two.
TEST(ReleaseInput, StatisticsCountTheMemoryOfTopology) {
  Memory memory;
  Device device("subdiv_accel=cbvh");
  rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
  SurfaceSettings settings;
  settings.rate = 4;
  RTCGeometry geometry = newSurface(device, sheetCage(91), settings);
  rtcCommitGeometry(geometry);
  const double bytes = double(memory.live);
  Scene scene(device);
  attach(scene, geometry);
  rtcCommitScene(scene);
  const double reported = double(statisticsOf(scene).inputBytes);
  EXPECT_GT(reported, 0.99 * bytes);
  EXPECT_LE(reported, bytes);
}

}} // namespace programs::test
