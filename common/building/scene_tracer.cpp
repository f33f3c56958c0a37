// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/scene_tracer.h"

namespace cbvh {

void EmbreeTracer::intersect(RTCRayHit* rays, size_t n) const
{
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (size_t i = 0; i < n; i++)
    rtcIntersect1(scene, &context, &rays[i]);
}

void EmbreeTracer::occluded(RTCRay* rays, size_t n) const
{
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (size_t i = 0; i < n; i++)
    rtcOccluded1(scene, &context, &rays[i]);
}

} // namespace cbvh
