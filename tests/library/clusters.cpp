// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Clusters of GPU formats: decoders written from the specifications find exactly the triangles that rays hit. */

#include "support/cluster_judge.h"
#include "support/diced_mesh.h"
#include "support/edge_rates.h"
#include "support/irregular_mesh.h"
#include "support/memory.h"
#include "support/message_parts.h"
#include "support/moving_surface.h"
#include "support/surface_access.h"

#include <gtest/gtest.h>

#include <exception>

namespace programs::test { namespace {

constexpr CbvhClusterFormat FLOAT3 = CBVH_CLUSTER_FORMAT_FLOAT3, COMPRESSED1 = CBVH_CLUSTER_FORMAT_COMPRESSED1,
                            DGF1 = CBVH_CLUSTER_FORMAT_DGF1;
const CbvhClusterFormat allFormats[] = {FLOAT3, COMPRESSED1, DGF1};
const char* nameOf(CbvhClusterFormat format) {
  return format == DGF1 ? "DGF1" : format == COMPRESSED1 ? "COMPRESSED1" : "floats";
}

// A compressed geometry, and the scene that committed it if it is a cage.
struct Stored {
  RTCGeometry geometry;

  explicit Stored(RTCGeometry geometry) : geometry(geometry) {}
  Stored(RTCDevice device, const Cage& cage, SurfaceSettings settings, RTCCompression kind = RTC_COMPRESSION_CVERT) {
    settings.compression = kind;
    geometry = newSurface(device, cage, settings);
    scene = rtcNewScene(device);
    rtcAttachGeometry(scene, geometry);
    rtcCommitScene(scene);
  }
  ~Stored() {
    rtcReleaseGeometry(geometry);
    if (scene) rtcReleaseScene(scene);
  }
  Stored(const Stored&) = delete;
  Stored& operator=(const Stored&) = delete;
  operator RTCGeometry() const { return geometry; }

private:
  RTCScene scene = nullptr;
};

// Checks all formats. allFit: no cluster falls back to floats.
void expectClusters(RTCGeometry geometry, bool allFit, float time = 0) {
  size_t triangles = 0;
  for (CbvhClusterFormat format : allFormats) {
    SCOPED_TRACE(nameOf(format));
    try {
      const ClusterJudge judge(geometry, time, format);
      EXPECT_GT(judge.statistics.numTriangles, 0u);
      if (format == FLOAT3) triangles = judge.statistics.numTriangles;
      EXPECT_EQ(judge.statistics.numTriangles, triangles);
      if (allFit) {
        EXPECT_EQ(judge.statistics.numClustersByReason[CBVH_CLUSTER_REASON_NONE], judge.statistics.numClusters);
      }
    } catch (const std::exception& error) { ADD_FAILURE() << error.what(); }
  }
}

TEST(Clusters, ClustersOfCagesMatchHitTriangles) {
  Device device;
  Random random(171);
  Displacement displacement;
  for (const auto& c : closedCages)
    for (const auto& rates : rateSets) {
      SCOPED_TRACE(testing::Message() << c.name << ", rates " << rates.name);
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.edgeRates = drawRates(c.cage, random, rates.draw);
      expectClusters(Stored(device, c.cage, settings), true);
    }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(Clusters, UnstitchedClustersAreWholeGrids) {
  Device device;
  SurfaceSettings settings;
  settings.rate = 32;
  Displacement displacement;
  settings.displacement = &displacement;
  const Stored cube(device, cubeCage(), settings);
  const ClusterJudge positions(cube, 0, COMPRESSED1), dgf(cube, 0, DGF1), floats(cube, 0, FLOAT3);
  EXPECT_EQ(positions.statistics.numClusters, 6 * 16u);
  EXPECT_EQ(positions.statistics.numVertices, 6 * 16 * 81u);
  EXPECT_EQ(positions.wholeClusters, 6 * 16u);
  EXPECT_EQ(positions.statistics.indexBytes, 0u);
  EXPECT_LT(positions.statistics.bytes, floats.statistics.bytes / 2);
  EXPECT_EQ(dgf.statistics.bytes, 128 * dgf.statistics.numClusters);
  EXPECT_LT(dgf.statistics.bytes, floats.statistics.bytes);
  EXPECT_LE(dgf.largestCluster, 64u);
}

TEST(Clusters, AnyScaleAndPositionIsSupported) {
  Device device;
  for (float scale : {1e-30f, 1e-6f, 1.0f, 1e6f, 1e12f})
    for (float away : {0.0f, 1.0f, -1000.0f, 3000.0f, 300000.0f}) {
      SCOPED_TRACE(testing::Message() << "scale " << scale << ", " << away << " of it away");
      Displacement displacement;
      displacement.scale = scale;
      displacement.offset = {away * scale, -away * scale, 0.5f * away * scale};
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.rate = 20;
      // farther away, vertices are finer than 24 bits
      expectClusters(Stored(device, creasedCube(), settings), away <= 3000);
    }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(Clusters, HolesAndNonFiniteVerticesAreLeftOut) {
  Device device;
  Random random(172);
  Displacement displacement;
  displacement.poison = [&](unsigned, float u, float v) { return std::fmod(97 * u + 31 * v, 1.0f) < 0.02f; };
  Cage cage = cubeCage();
  cage.holes = {2};
  for (float rate : {5.0f, 24.0f, 33.0f}) {
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.rate = rate;
    expectClusters(Stored(device, cage, settings), false);
  }
}

TEST(Clusters, GridsQuadsAndTrianglesAreSupported) {
  Device device;
  Random random(173);
  std::vector<Diced> all = {dicedSheet(1, 50), dicedSheet(3, 8), dicedBall(2, 9), dicedBall(2, 17, 3)};
  for (const Diced& diced : all) {
    expectClusters(Stored(newGrids(device, diced, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT)), false);
    const DicedMesh quads = meshOf(diced, QuadOrder::Rows, random);
    for (const DicedMesh& mesh : {quads, trianglesOf(quads), trianglesOf(quads, 1, 2)})
      expectClusters(Stored(newMesh(device, mesh, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT)), false);
  }
  expectClusters(Stored(newMesh(device, globe(40, 30), RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT)),
                 false);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(Clusters, ReasonForFloatsIsReported) {
  Device device;
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  const auto reasonOf = [&](RTCGeometry geometry, float time, CbvhClusterFormat format) {
    const ClusterJudge judge(geometry, time, format);
    for (int i = 0; i < 4; i++)
      if (judge.statistics.numClustersByReason[i] == judge.statistics.numClusters) return i;
    return -1;
  };
  const Stored raw(device, cubeCage(), settings, RTC_COMPRESSION_CGRID);
  settings.timeSteps = 3;
  settings.motion = [](const Vec& p, unsigned i) { return i ? twisted(p, 0.3 * i) : p; };
  const Stored moving(device, cubeCage(), settings);
  for (CbvhClusterFormat format : {COMPRESSED1, DGF1}) {
    EXPECT_EQ(reasonOf(raw, 0, format), int(CBVH_CLUSTER_REASON_FLOATS));
    EXPECT_EQ(reasonOf(moving, 0.3f, format), int(CBVH_CLUSTER_REASON_MOVING));
    for (float step : {0.0f, 0.5f, 1.0f}) EXPECT_EQ(reasonOf(moving, step, format), int(CBVH_CLUSTER_REASON_NONE));
  }
  Device lossless("cbvh_max_error=0");
  Random random(91);
  const DicedMesh triangles = irregularTriangles(meshOf(dicedSheet(2, 16), QuadOrder::Rows, random), random);
  const Stored mesh(newMesh(lossless, triangles, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT));
  const ClusterJudge exact(mesh, 0, COMPRESSED1);
  EXPECT_GT(exact.statistics.numClustersByReason[CBVH_CLUSTER_REASON_FLOATS], 0u);
  EXPECT_EQ(exact.statistics.numClustersByReason[CBVH_CLUSTER_REASON_OUT_OF_RANGE], 0u);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(Clusters, StitchedGridsStayClosedIfSomeClustersHaveFloats) {
  Device device;
  Diced diced;
  const auto position = [](double x, double y) {
    return Vec{float(x), float(y), float(0.1 * std::sin(5 * x + 3 * y))};
  };
  diced.add(9, 9, [&](unsigned x, unsigned y) { return position(x / 8.0, y / 8.0); });
  diced.add(25, 25, [&](unsigned x, unsigned y) {
    if (x > 0) return position(1 + x / 24.0, y / 24.0);
    // on an edge of the coarser grid; a third is on no lattice
    const Vec a = position(1, y / 3 / 8.0), b = position(1, (y / 3 + 1) / 8.0);
    const float t = float(y % 3) / 3;
    return Vec{a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2])};
  });
  const Stored grids(newGrids(device, diced, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT));
  for (CbvhClusterFormat format : {COMPRESSED1, DGF1}) {
    const ClusterJudge judge(grids, 0, format);
    EXPECT_GT(judge.statistics.numClustersByReason[CBVH_CLUSTER_REASON_FLOATS], 0u);
    EXPECT_GT(judge.statistics.numClustersByReason[CBVH_CLUSTER_REASON_NONE], 0u);
    EXPECT_EQ(judge.statistics.numTriangles, 2 * diced.quads());
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

TEST(Clusters, EmptyInputAndUnknownFormatsAreErrors) {
  Device device;
  SurfaceSettings settings;
  const Stored cube(device, cubeCage(), settings);
  CbvhClusterStatistics statistics;
  forEachStoredCluster(nullptr, 0, DGF1, nullptr, nullptr, &statistics);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT) << "without a geometry the error is the thread's";
  forEachStoredCluster(cube, 0, CbvhClusterFormat(3), nullptr, nullptr, &statistics);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"format", " 3", " 2"}));
  const Stored leaves(device, cubeCage(), settings, RTC_COMPRESSION_CLEAF);
  forEachStoredCluster(leaves, 0, DGF1, nullptr, nullptr, &statistics);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  forEachStoredCluster(cube, 0, DGF1, nullptr, nullptr, nullptr);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  size_t calls = 0;
  forEachStoredCluster(
      cube, 0, DGF1, [](void* n, const CbvhCluster*) { return ++*(size_t*)n < 3; }, &calls, &statistics);
  EXPECT_EQ(calls, 3u) << "false ends the calls";
  EXPECT_EQ(statistics.numClusters, 3u);
}

TEST(Clusters, CallbackMayReleaseTheGeometry) {
  Memory memory;
  Device device;
  rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
  struct Callback {
    RTCGeometry geometry;
    Memory& memory;
    ssize_t freed;
  } callback = {nullptr, memory, 0};
  callback.geometry = newGrids(device, dicedSheet(4, 64), RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT);
  const ssize_t before = memory.live;
  CbvhClusterStatistics statistics;
  forEachStoredCluster(
      callback.geometry, 0, COMPRESSED1,
      [](void* self, const CbvhCluster*) {
        Callback& callback = *(Callback*)self;
        if (!callback.geometry) return true;
        const ssize_t before = callback.memory.live;
        rtcReleaseGeometry(callback.geometry);
        callback.geometry = nullptr;
        callback.freed = before - callback.memory.live;
        return true;
      },
      &callback, &statistics);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_EQ(callback.freed, 0) << "blocks were freed during the call";
  EXPECT_EQ(statistics.numTriangles, 2u * 256 * 256);
  EXPECT_LT(memory.live, before);
}

}} // namespace programs::test
