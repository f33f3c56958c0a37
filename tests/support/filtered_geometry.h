// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A geometry with filter functions, in its own scene and in an instance of it. */

#include "support/scene.h"

namespace cbvh::test {

// Sets filters that reject hits depending on the values that they receive.
inline void setFilters(RTCGeometry geometry)
{
  const auto filter = [](const RTCFilterFunctionNArguments* args) {
    for (unsigned k = 0; k < args->N; k++)
      if (args->valid[k] == -1 &&
          (RTCHitN_primID(args->hit, args->N, k) % 3 == 0 || RTCHitN_u(args->hit, args->N, k) > 0.6f))
        args->valid[k] = 0;
  };
  rtcSetGeometryIntersectFilterFunction(geometry, filter);
  rtcSetGeometryOccludedFilterFunction(geometry, filter);
}

// Commits both scenes and releases `geometry`. transforms: of the instance, one per time step.
inline void attachFiltered(RTCDevice device, RTCGeometry geometry, RTCScene scene, RTCScene top,
                           const std::vector<std::array<float, 12>>& transforms)
{
  setFilters(geometry);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, 3);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(instance, scene);
  rtcSetGeometryTimeStepCount(instance, unsigned(transforms.size()));
  for (size_t i = 0; i < transforms.size(); i++)
    rtcSetGeometryTransform(instance, unsigned(i), RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transforms[i].data());
  rtcCommitGeometry(instance);
  rtcAttachGeometry(top, instance);
  rtcReleaseGeometry(instance);
  rtcCommitScene(top);
}

} // namespace cbvh::test
