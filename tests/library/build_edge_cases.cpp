// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Builds of unusual input: faces without valid vertices, displacement functions with changing results, geometries
 * without faces. */

#include "support/displaced_sheet.h"

#include <cmath>

namespace programs::test { namespace {

// Independently of the tasks that build both.
TEST(BuildEdgeCases, FaceWithoutValidVerticesDoesNotAffectNeighbors) {
  Device device("threads=1,subdiv_accel=cbvh.leaf");
  Scene scene(device);
  DisplaceFunction poison =
                       [](unsigned primID, float, float, Vec& p) {
                         if (primID == 0) p[2] = NAN;
                       },
                   none = [](unsigned, float, float, Vec&) {};
  for (int m = 0; m < 2; m++) {
    RTCGeometry geometry = newSheet(device, m ? 4 : 2, 10.f * m, 64, m ? none : poison);
    rtcCommitGeometry(geometry);
    attach(scene, geometry);
  }
  rtcCommitScene(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 4096u);
  for (int f = 0; f < 6; f++)
    for (int i = 0; i < 64; i++) {
      const float x = (f < 2 ? f : 10 + f - 2) + (i % 8 + 0.3f) / 8, y = (i / 8 + 0.4f) / 8;
      EXPECT_EQ(isHit(intersect(scene, makeRay({x, y, 1}, {0, 0, -1}))), f != 0)
          << "face " << f << " at " << x << ", " << y;
    }
}

// Frame levels for an error bound are chosen once. Other values later must not overflow buffers.
TEST(BuildEdgeCases, DisplacementMayReturnDifferentValuesLater) {
  Device device("threads=1,subdiv_accel=cbvh.leaf,cbvh_frame_level=auto,cbvh_max_error=0.0005,cbvh_fallback_faces=0");
  Scene scene(device);
  size_t calls = 0;
  DisplaceFunction rougher = [&](unsigned, float u, float v, Vec& p) {
    const float amplitude = calls++ < 4 * 33 * 33 ? 0.f : 0.1f;
    p[2] = amplitude * std::sin(40 * u) * std::sin(40 * v);
  };
  commit(scene, newSheet(device, 4, 0, 32, rougher));
  ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_EQ(statisticsOf(scene).numBlocks, 4u);
}

// Boxes that count calls of their bounds function, enough for a tree of their own.
RTCGeometry newBoxes(RTCDevice device, unsigned& asked) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, 100);
  rtcSetGeometryUserData(geometry, &asked);
  rtcSetGeometryBoundsFunction(
      geometry,
      [](const RTCBoundsFunctionArguments* args) {
        ++*(unsigned*)args->geometryUserPtr;
        *args->bounds_o = RTCBounds{0, 0, 0, 0, 1, 1, 1, 0};
      },
      nullptr);
  rtcCommitGeometry(geometry);
  return geometry;
}

// A compressed geometry without faces has no accelerator. If dynamic scenes created one at every commit, other
// geometries would be rebuilt.
TEST(BuildEdgeCases, GeometryWithoutFacesDoesNotCauseRebuilds) {
  Device device("threads=1,subdiv_accel=cbvh.leaf");
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  // one tree per geometry; trees of unchanged geometries are kept
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_LOW);
  addSurface(device, scene, Cage(), SurfaceSettings());
  unsigned asked = 0, askedOther = 0;
  attach(scene, newBoxes(device, asked));
  const unsigned other = attach(scene, newBoxes(device, askedOther));
  rtcCommitScene(scene);
  asked = askedOther = 0;
  rtcCommitGeometry(rtcGetGeometry(scene, other));
  rtcCommitScene(scene);
  EXPECT_GT(askedOther, 0u);
  EXPECT_EQ(asked, 0u) << "an unchanged geometry was rebuilt";
  const RTCCompressionStatistics stats = statisticsOf(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_EQ(stats.numBlocks + stats.numQuads + stats.topLevelBytes, 0u);
}

}} // namespace programs::test
