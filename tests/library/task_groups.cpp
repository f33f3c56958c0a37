// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Applications commit in tasks of their own groups. A scene keeps no reference to such a group, and a commit completes
 * although its group is canceled. */

#include "support/child_process.h"
#include "support/irregular_mesh.h"
#include "support/task_groups.h"

namespace programs::test { namespace {

enum class Source { Triangles, Cage, Grids, Mesh };

struct Kind {
  const char* name;
  Source source;
  RTCCompression compression;
  unsigned timeSteps;
};

const Kind kinds[] = {
    {"triangles", Source::Triangles, RTC_COMPRESSION_NONE, 1},
    {"moving triangles", Source::Triangles, RTC_COMPRESSION_NONE, 2},
    {"GRID", Source::Cage, RTC_COMPRESSION_NONE, 1},
    {"moving GRID", Source::Cage, RTC_COMPRESSION_NONE, 2},
    {"cVERT", Source::Cage, RTC_COMPRESSION_CVERT, 1},
    {"moving cVERT", Source::Cage, RTC_COMPRESSION_CVERT, 2},
    {"cLEAF", Source::Cage, RTC_COMPRESSION_CLEAF, 1},
    {"grids", Source::Grids, RTC_COMPRESSION_CVERT, 1},
    {"moving grids", Source::Grids, RTC_COMPRESSION_CVERT, 2},
    {"quads", Source::Mesh, RTC_COMPRESSION_CVERT, 1},
    {"moving quads", Source::Mesh, RTC_COMPRESSION_CVERT, 2},
};

// Every kind extends over the middle of [-1,1]^2, and is committed here.
RTCGeometry newGeometry(RTCDevice device, const Kind& kind, Displacement& displacement) {
  const Diced sheet = dicedSheet(3, 16, 0x1p-10);
  Random random(7);
  switch (kind.source) {
  case Source::Cage: {
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.compression = kind.compression;
    settings.timeSteps = kind.timeSteps;
    return newSurface(device, sheetCage(4), settings);
  }
  case Source::Grids: return newGrids(device, sheet, kind.compression, 0, kind.timeSteps);
  default: {
    DicedMesh mesh = meshOf(sheet, QuadOrder::Rows, random);
    if (kind.source == Source::Triangles) mesh = irregularTriangles(mesh, random);
    return newMesh(device, mesh, kind.compression, 0, kind.timeSteps);
  }
  }
}

// Exit status of a child process, which a commit that keeps a pointer into the group ends by a segmentation fault.
int commitInTemporaryGroups(const Kind& kind, void (*commitScene)(RTCScene)) {
  Device device;
  Displacement displacement;
  bool hits[2];
  {
    Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
    RTCGeometry geometry = nullptr;
    runInTemporaryGroup([&] { geometry = newGeometry(device, kind, displacement); });
    cancelOtherGroup();
    rtcAttachGeometry(scene, geometry);
    for (bool& hit : hits) {
      runInTemporaryGroup([&] { runInTemporaryGroup([&] { commitScene(scene); }); });
      cancelOtherGroup();
      hit = isHit(intersect(scene, makeRay({0.01f, 0.02f, 5}, {0, 0, -1})));
      rtcSetGeometryMask(geometry, 3);
      rtcCommitGeometry(geometry);
    }
    rtcReleaseGeometry(geometry);
  }
  cancelOtherGroup();
  return device.takeError() == RTC_ERROR_NONE && hits[0] && hits[1] ? 0 : 1;
}

TEST(TaskGroups, ScenesOutliveTheGroupThatCommitsThem) {
  for (const Kind& kind : kinds)
    for (auto commitScene : {rtcCommitScene, rtcJoinCommitScene}) {
      SCOPED_TRACE(std::string(kind.name) + (commitScene == rtcCommitScene ? "" : ", joined"));
      EXPECT_EQ(statusOfChild([&] { return commitInTemporaryGroups(kind, commitScene); }), 0);
    }
}

TEST(TaskGroups, CommitsInACanceledGroupComplete) {
  for (const Kind& kind : kinds) {
    SCOPED_TRACE(kind.name);
    Device device;
    Displacement displacement;
    Scene scene(device);
    tbb::task_group group;
    group.run([&] {
      group.cancel();
      attach(scene, newGeometry(device, kind, displacement));
      rtcCommitScene(scene);
    });
    group.wait();
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_TRUE(isHit(intersect(scene, makeRay({0.01f, 0.02f, 5}, {0, 0, -1}))));
  }
}

}} // namespace programs::test
