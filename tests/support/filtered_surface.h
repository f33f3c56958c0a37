// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "support/scene.h"

namespace cbvh::test {

// Adds the cube as the only geometry of a scene, with a filter for closest hit and for any hit, and commits the
// scene.
inline void addFilteredCube(RTCDevice device, RTCScene scene, const SurfaceSettings& settings,
                            RTCFilterFunctionN filter)
{
  RTCGeometry geometry = newSurface(device, cubeCage(), settings);
  rtcSetGeometryIntersectFilterFunction(geometry, filter);
  rtcSetGeometryOccludedFilterFunction(geometry, filter);
  rtcCommitGeometry(geometry);
  attach(scene, geometry);
  rtcCommitScene(scene);
}

} // namespace cbvh::test
