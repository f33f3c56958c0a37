// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/scene_tracer.h"

namespace programs {
namespace {

RTCIntersectContext coherentContext() {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  return context;
}

} // namespace

void EmbreeTracer::intersect(RTCRayHit* rays, size_t n) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (size_t i = 0; i < n; i++) rtcIntersect1(scene, &context, &rays[i]);
}

void EmbreeTracer::occluded(RTCRay* rays, size_t n) const {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (size_t i = 0; i < n; i++) rtcOccluded1(scene, &context, &rays[i]);
}

/* Embree splits a stream of coherent rays into packets. */
void PacketTracer::intersect(RTCRayHit* rays, size_t n) const {
  RTCIntersectContext context = coherentContext();
  rtcIntersect1M(scene, &context, rays, unsigned(n), sizeof(RTCRayHit));
}

void PacketTracer::occluded(RTCRay* rays, size_t n) const {
  RTCIntersectContext context = coherentContext();
  rtcOccluded1M(scene, &context, rays, unsigned(n), sizeof(RTCRay));
}

} // namespace programs
