// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "support/scene.h"

namespace cbvh::test {

// The cube, alone in a committed scene, with a filter for closest hit and for any hit.
inline void addFilteredCube(RTCDevice device, RTCScene scene, const SurfaceSettings& settings, RTCFilterFunctionN filter)
{
  RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  rtcSetGeometryIntersectFilterFunction(geometry, filter);
  rtcSetGeometryOccludedFilterFunction(geometry, filter);
  rtcCommitGeometry(geometry);
  attach(scene, geometry);
  rtcCommitScene(scene);
}

} // namespace cbvh::test
