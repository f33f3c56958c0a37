// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "support/scene.h"

#include <cstddef>
#include <cstring>
#include <vector>

namespace programs::test {

enum class QueryForm { Single, Packet4, Packet8, Packet16, Coherent8, Stream, CoherentStream, Pointers };
const QueryForm allQueryForms[] = {QueryForm::Single,         QueryForm::Packet4,   QueryForm::Packet8,
                                   QueryForm::Packet16,       QueryForm::Coherent8, QueryForm::Stream,
                                   QueryForm::CoherentStream, QueryForm::Pointers};

inline const char* nameOf(QueryForm form) {
  switch (form) {
  case QueryForm::Single: return "single rays";
  case QueryForm::Packet4: return "packets of 4";
  case QueryForm::Packet8: return "packets of 8";
  case QueryForm::Packet16: return "packets of 16";
  case QueryForm::Coherent8: return "coherent packets of 8";
  case QueryForm::Stream: return "a stream";
  case QueryForm::CoherentStream: return "a coherent stream";
  case QueryForm::Pointers: return "a stream of pointers";
  }
  return "";
}

// Traces the closest hits. For any hit, returns rays whose tfar is negative if they are occluded.
class QueryRun {
public:
  QueryRun(RTCScene scene, QueryForm form, bool any) : scene(scene), form(form), any(any) {
    rtcInitIntersectContext(&context);
  }

  RTCIntersectContext context;

  std::vector<RTCRayHit> operator()(const std::vector<RTCRayHit>& rays) {
    std::vector<RTCRayHit> traced = rays;
    const bool coherent = form == QueryForm::Coherent8 || form == QueryForm::CoherentStream;
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    switch (form) {
    case QueryForm::Single:
      for (RTCRayHit& r : traced) {
        if (any) rtcOccluded1(scene, &context, &r.ray);
        else rtcIntersect1(scene, &context, &r);
      }
      break;
    case QueryForm::Packet4: packets<4, RTCRayHit4>(traced, rtcIntersect4, rtcOccluded4); break;
    case QueryForm::Packet8:
    case QueryForm::Coherent8: packets<8, RTCRayHit8>(traced, rtcIntersect8, rtcOccluded8); break;
    case QueryForm::Packet16: packets<16, RTCRayHit16>(traced, rtcIntersect16, rtcOccluded16); break;
    case QueryForm::Stream:
    case QueryForm::CoherentStream:
      if (any) rtcOccluded1M(scene, &context, &traced[0].ray, unsigned(traced.size()), sizeof(RTCRayHit));
      else rtcIntersect1M(scene, &context, traced.data(), unsigned(traced.size()), sizeof(RTCRayHit));
      break;
    case QueryForm::Pointers: {
      std::vector<RTCRayHit*> pointers;
      std::vector<RTCRay*> rayPointers;
      for (RTCRayHit& r : traced) {
        pointers.push_back(&r);
        rayPointers.push_back(&r.ray);
      }
      if (any) rtcOccluded1Mp(scene, &context, rayPointers.data(), unsigned(traced.size()));
      else rtcIntersect1Mp(scene, &context, pointers.data(), unsigned(traced.size()));
      break;
    }
    }
    return traced;
  }

private:
  // Lanes after the last ray are inactive.
  template<unsigned N, typename Packet, typename Ray>
  void packets(std::vector<RTCRayHit>& rays, void (*intersect)(const int*, RTCScene, RTCIntersectContext*, Packet*),
               void (*occluded)(const int*, RTCScene, RTCIntersectContext*, Ray*)) {
    for (size_t first = 0; first < rays.size(); first += N) {
      alignas(64) Packet packet;
      alignas(64) int valid[N];
      uint32_t* lanes = (uint32_t*)&packet;
      std::memset(&packet, 0, sizeof(packet));
      for (unsigned k = 0; k < N; k++) {
        valid[k] = first + k < rays.size() ? -1 : 0;
        if (valid[k])
          forWords(
              [&](size_t w, size_t p) { std::memcpy(lanes + p * N + k, (const char*)&rays[first + k] + 4 * w, 4); });
      }
      if (any) occluded(valid, scene, &context, &packet.ray);
      else intersect(valid, scene, &context, &packet);
      for (unsigned k = 0; k < N; k++)
        if (valid[k])
          forWords([&](size_t w, size_t p) { std::memcpy((char*)&rays[first + k] + 4 * w, lanes + p * N + k, 4); });
    }
  }

  // Calls closure(word of RTCRayHit, row of a packet). The rows of a packet are consecutive; RTCRayHit
  // aligns its ray and its hit.
  template<typename Closure>
  static void forWords(const Closure& closure) {
    size_t p = 0;
    for (size_t w = 0; w < offsetof(RTCRay, flags) / 4 + 1; w++) closure(w, p++);
    for (size_t w = 0; w < offsetof(RTCHit, instID) / 4 + RTC_MAX_INSTANCE_LEVEL_COUNT; w++)
      closure(offsetof(RTCRayHit, hit) / 4 + w, p++);
  }

  RTCScene scene;
  QueryForm form;
  bool any;
};

inline std::vector<RTCRayHit> closestHits(RTCScene scene, const std::vector<RTCRayHit>& rays, QueryForm form) {
  return QueryRun(scene, form, false)(rays);
}
inline std::vector<RTCRayHit> anyHits(RTCScene scene, const std::vector<RTCRayHit>& rays, QueryForm form) {
  return QueryRun(scene, form, true)(rays);
}

} // namespace programs::test
