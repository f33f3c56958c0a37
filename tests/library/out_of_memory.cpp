// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A commit that runs out of memory at any point reports it and loses no data; the next commit succeeds. */

#include "support/diced_mesh.h"

#include <gtest/gtest.h>

#include <atomic>

namespace programs::test { namespace {

// Refuses call `refusedCall` after it is armed, if the call is an allocation.
struct Monitor {
  std::atomic<ssize_t> live{0};
  std::atomic<long> calls{0}, refused{0}; // while armed; calls include releases
  long refusedCall = 0;                   // 0: no call
  std::atomic<bool> isArmed{false};

  static bool function(void* self, ssize_t bytes, bool isAllocated) {
    Monitor& m = *(Monitor*)self;
    const bool refuses = m.isArmed && ++m.calls == m.refusedCall && bytes > 0;
    if (refuses) m.refused++;
    if (!refuses || isAllocated) m.live += bytes;
    return !refuses;
  }
};

Vec moved(const Vec& p, unsigned step) { return {p[0] + float(step), p[1] * float(1 + step), p[2]}; }

RTCGeometry newGeometry(RTCDevice device, int type, unsigned timeSteps) {
  Random random(1);
  if (type == 0) {
    SurfaceSettings settings;
    settings.compression = RTC_COMPRESSION_CVERT;
    settings.timeSteps = timeSteps;
    settings.motion = moved;
    return newSurface(device, cubeCage(), settings);
  }
  Diced grids = dicedSheet(2, 16);
  grids.motion = moved;
  if (type == 1) return newGrids(device, grids, RTC_COMPRESSION_CVERT, 0, timeSteps);
  DicedMesh mesh = meshOf(grids, QuadOrder::Recursive, random);
  mesh.motion = moved;
  return newMesh(device, type == 2 ? mesh : trianglesOf(mesh), RTC_COMPRESSION_CVERT, 0, timeSteps);
}

// Changes and commits a geometry and its scene, then again with enough memory. Returns the monitor's calls
// during the first commits, including releases.
long commitWithout(long refusedCall, int type, unsigned timeSteps, RTCSceneFlags flags) {
  Monitor monitor;
  monitor.refusedCall = refusedCall;
  {
    Device device("threads=1");
    rtcSetDeviceMemoryMonitorFunction(device, Monitor::function, &monitor);
    Scene scene(device, flags);
    RTCGeometry geometry = newGeometry(device, type, timeSteps);
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcAttachGeometry(scene, geometry);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    monitor.isArmed = true;
    rtcCommitGeometry(geometry);
    const RTCError ofGeometry = device.takeError();
    EXPECT_EQ(ofGeometry, RTC_ERROR_NONE) << device.message << ": commits of geometries are not expected to fail";
    // A refusal would be lost if the geometry were detached now.
    EXPECT_EQ(monitor.calls, 0) << "the monitor was asked during the commit of a geometry";
    rtcCommitScene(scene);
    EXPECT_EQ(device.takeError(), monitor.refused ? RTC_ERROR_OUT_OF_MEMORY : RTC_ERROR_NONE) << device.message;
    monitor.isArmed = false;
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_GT(statisticsOf(scene).numQuads, 0u);
  }
  EXPECT_EQ(monitor.live, 0);
  return monitor.calls;
}

TEST(OutOfMemory, NothingIsLostAndNextCommitSucceeds) {
  for (int type : {0, 1, 2, 3})
    for (unsigned timeSteps : {1u, 3u})
      for (RTCSceneFlags flags : {RTC_SCENE_FLAG_NONE, RTC_SCENE_FLAG_DYNAMIC}) {
        SCOPED_TRACE(testing::Message() << "type " << type << ", " << timeSteps << " time steps, flags " << flags);
        const long calls = commitWithout(0, type, timeSteps, flags);
        ASSERT_GT(calls, 10);
        for (long call = 1; call <= calls && !testing::Test::HasFailure(); call++) {
          SCOPED_TRACE(testing::Message() << "call " << call << " of " << calls);
          commitWithout(call, type, timeSteps, flags);
        }
      }
}

}} // namespace programs::test
