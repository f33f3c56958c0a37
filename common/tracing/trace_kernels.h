// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Loops that trace rays with every query of Embree's API. A sink receives the hits, to count or to store them, and is
 * compiled into the loop. Its members:
 *
 *   void closest(size_t i, const RTCRayHit& ray);                    // the closest hit of ray i
 *   void closest(size_t i, const RTCRayHitN& packet, size_t lane);
 *   void any(size_t i, float tfar);                                  // tfar < 0 if ray i hits anything */

#include "tracing/ray_conversion.h"
#include "tracing/trace_modes.h"

#include <algorithm>

namespace programs {

/* Rays per task: whole packets and streams, and 64 tiles of 8 x 8 pixels. */
constexpr size_t traceChunk = 4096;
static_assert(traceChunk % streamSize == 0, "only the last call of a set is not full");

/* `coherent` is the flag that Embree receives. */
inline RTCIntersectContext traceContext(bool coherent) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  return context;
}

/* Traces rays [0,n). The sink is passed by value so that a count stays in a register. */
template<typename Sink>
using Kernel = Sink (*)(RTCScene, RTCIntersectContext&, const Ray*, size_t n, Sink);

namespace kernels {

template<typename Sink>
Sink closestSingle(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n, Sink sink) {
  for (size_t i = 0; i < n; i++) {
    RTCRayHit ray;
    load(rays[i], ray.ray);
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &ray);
    sink.closest(i, ray);
  }
  return sink;
}

template<typename Sink>
Sink anySingle(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n, Sink sink) {
  for (size_t i = 0; i < n; i++) {
    RTCRay ray;
    load(rays[i], ray);
    rtcOccluded1(scene, &context, &ray);
    sink.any(i, ray.tfar);
  }
  return sink;
}

struct Packet4 {
  static constexpr size_t size = 4;
  using Ray = RTCRay4;
  using RayHit = RTCRayHit4;
  static void closest(const int* valid, RTCScene s, RTCIntersectContext* c, RayHit* r) {
    rtcIntersect4(valid, s, c, r);
  }
  static void any(const int* valid, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded4(valid, s, c, r); }
};

struct Packet8 {
  static constexpr size_t size = 8;
  using Ray = RTCRay8;
  using RayHit = RTCRayHit8;
  static void closest(const int* valid, RTCScene s, RTCIntersectContext* c, RayHit* r) {
    rtcIntersect8(valid, s, c, r);
  }
  static void any(const int* valid, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded8(valid, s, c, r); }
};

struct Packet16 {
  static constexpr size_t size = 16;
  using Ray = RTCRay16;
  using RayHit = RTCRayHit16;
  static void closest(const int* valid, RTCScene s, RTCIntersectContext* c, RayHit* r) {
    rtcIntersect16(valid, s, c, r);
  }
  static void any(const int* valid, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded16(valid, s, c, r); }
};

/* Lanes beyond n repeat the last ray and are inactive. */
template<typename Packet, typename PacketRay>
size_t loadPacket(const Ray* rays, size_t n, PacketRay& packet, int* valid) {
  const size_t active = std::min(n, Packet::size);
  for (size_t i = 0; i < Packet::size; i++) {
    valid[i] = i < active ? -1 : 0;
    load(rays[std::min(i, active - 1)], packet, i);
  }
  return active;
}

template<typename Packet, typename Sink>
Sink closestPackets(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n, Sink sink) {
  alignas(64) int valid[Packet::size];
  alignas(64) typename Packet::RayHit packet;
  for (size_t i = 0; i < n; i += Packet::size) {
    const size_t active = loadPacket<Packet>(rays + i, n - i, packet.ray, valid);
    for (size_t k = 0; k < Packet::size; k++) {
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    Packet::closest(valid, scene, &context, &packet);
    for (size_t k = 0; k < active; k++) sink.closest(i + k, packet, k);
  }
  return sink;
}

template<typename Packet, typename Sink>
Sink anyPackets(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n, Sink sink) {
  alignas(64) int valid[Packet::size];
  alignas(64) typename Packet::Ray packet;
  for (size_t i = 0; i < n; i += Packet::size) {
    const size_t active = loadPacket<Packet>(rays + i, n - i, packet, valid);
    Packet::any(valid, scene, &context, &packet);
    for (size_t k = 0; k < active; k++) sink.any(i + k, packet.tfar[k]);
  }
  return sink;
}

template<typename Sink>
Sink closestStreams(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n, Sink sink) {
  alignas(64) RTCRayHit stream[streamSize];
  for (size_t i = 0; i < n; i += streamSize) {
    const size_t active = std::min(n - i, streamSize);
    for (size_t k = 0; k < active; k++) {
      load(rays[i + k], stream[k].ray);
      stream[k].hit.geomID = RTC_INVALID_GEOMETRY_ID;
      stream[k].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect1M(scene, &context, stream, unsigned(active), sizeof(RTCRayHit));
    for (size_t k = 0; k < active; k++) sink.closest(i + k, stream[k]);
  }
  return sink;
}

template<typename Sink>
Sink anyStreams(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n, Sink sink) {
  alignas(64) RTCRay stream[streamSize];
  for (size_t i = 0; i < n; i += streamSize) {
    const size_t active = std::min(n - i, streamSize);
    for (size_t k = 0; k < active; k++) load(rays[i + k], stream[k]);
    rtcOccluded1M(scene, &context, stream, unsigned(active), sizeof(RTCRay));
    for (size_t k = 0; k < active; k++) sink.any(i + k, stream[k].tfar);
  }
  return sink;
}

} // namespace kernels

template<typename Sink>
Kernel<Sink> kernelOf(TraceMode mode, Query query) {
  using namespace kernels;
  const bool closest = query == Closest;
  switch (mode) {
  case TraceMode::Packet4: return closest ? closestPackets<Packet4, Sink> : anyPackets<Packet4, Sink>;
  case TraceMode::Packet8: return closest ? closestPackets<Packet8, Sink> : anyPackets<Packet8, Sink>;
  case TraceMode::Packet16: return closest ? closestPackets<Packet16, Sink> : anyPackets<Packet16, Sink>;
  case TraceMode::Stream: return closest ? closestStreams<Sink> : anyStreams<Sink>;
  default: return closest ? closestSingle<Sink> : anySingle<Sink>;
  }
}

} // namespace programs
