// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "support/same_hits.h"

namespace programs::test {

// Commits a scene of the cube with a filter for closest and any hit.
inline void addFilteredCube(RTCDevice device, RTCScene scene, const SurfaceSettings& settings,
                            RTCFilterFunctionN filter) {
  RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  rtcSetGeometryIntersectFilterFunction(geometry, filter);
  rtcSetGeometryOccludedFilterFunction(geometry, filter);
  rtcCommitGeometry(geometry);
  attach(scene, geometry);
  rtcCommitScene(scene);
}

// Rejects hits by their primID and u.
inline void filterByValues(const RTCFilterFunctionNArguments* args) {
  for (unsigned k = 0; k < args->N; k++)
    if (args->valid[k] == -1 &&
        (RTCHitN_primID(args->hit, args->N, k) % 3 == 0 || RTCHitN_u(args->hit, args->N, k) > 0.6f))
      args->valid[k] = 0;
}

// Expects the same hits with and without compression from a geometry with a mask and filters, in a scene and in an
// instance, which moves if the geometry does. newGeometry(compression) returns a geometry without a scene.
template<typename NewGeometry>
void expectSameFilteredHits(Device& device, const NewGeometry& newGeometry, bool moves, std::vector<RTCRayHit> rays,
                            double slack, size_t maxOthers = 0) {
  const float transforms[2][12] = {{0, 1, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0.0625f},
                                   {0, 1, 0, -1, 0, 0, 0, 0, 1, 0.5f, 0, 0.0625f}};
  Scene scenes[2] = {Scene(device), Scene(device)}, tops[2] = {Scene(device), Scene(device)};
  for (int i = 0; i < 2; i++) {
    RTCGeometry geometry = newGeometry(i ? RTC_COMPRESSION_CVERT : RTC_COMPRESSION_NONE);
    rtcSetGeometryMask(geometry, 2);
    rtcSetGeometryIntersectFilterFunction(geometry, filterByValues);
    rtcSetGeometryOccludedFilterFunction(geometry, filterByValues);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scenes[i], geometry, 3);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scenes[i]);
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, scenes[i]);
    rtcSetGeometryTimeStepCount(instance, moves ? 2 : 1);
    for (unsigned t = 0; t < (moves ? 2 : 1); t++)
      rtcSetGeometryTransform(instance, t, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transforms[t]);
    rtcCommitGeometry(instance);
    attach(tops[i], instance);
    rtcCommitScene(tops[i]);
  }
  const RTCCompressionStatistics stats = statisticsOf(scenes[1]);
  ASSERT_GT(stats.numQuads, 0u);
  ASSERT_EQ(stats.numMovingQuads, moves ? stats.numQuads : 0);
  for (size_t i = 0; i < rays.size(); i++) rays[i].ray.mask = i % 5 ? 3 : 1;
  for (const Scene* of : {scenes, tops}) {
    SCOPED_TRACE(of == tops ? "in an instance" : "");
    ASSERT_NO_FATAL_FAILURE(expectSameQueries(of[0], of[1], rays, slack, maxOthers));
    size_t hits = 0;
    for (const RTCRayHit& ray : rays) hits += isHit(intersect(of[1], ray));
    EXPECT_GT(hits, rays.size() / 5);
    EXPECT_LT(hits, rays.size() * 9 / 10);
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

} // namespace programs::test
