// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

// Traces a ray through a block by closest hit and any hit, with filters that accept and reject hits, and compares the
// results.

#include "fuzz_support.h"
#include "kernels/common/context.h"
#include "kernels/cvert/portable/world.h"

#include <cmath>

namespace programs::test {

using namespace embree;
using cvert::isFinite;
using cvert::maxCoordinate;

// True for rays within Embree's limits. The distances of other rays' hits are arbitrary, as in Embree.
inline bool isSound(const RayBytes& ray) {
  double length = 0;
  for (float d : ray.dir) length = std::fmax(length, std::fabs(d));
  return isFinite(ray.org) && isFinite(ray.dir) && length >= 1e-18f && ray.tnear >= 0 && ray.tnear <= maxCoordinate &&
         ray.tfar >= ray.tnear;
}

struct HitLimits {
  size_t most; // number of candidates of a ray
  float u, v;  // smallest parameters
};

// A context whose filter receives every candidate.
struct FilteredTrace : RTCIntersectContext {
  const HitLimits limits;
  bool sound, accepts;
  size_t hits = 0;
  float tnear, tfar;

  FilteredTrace(const HitLimits& limits, const RayBytes& ray, bool accepts)
    : limits(limits),
      sound(isSound(ray)),
      accepts(accepts),
      tnear(ray.tnear),
      tfar(ray.tfar) {
    rtcInitIntersectContext(this);
    filter = [](const RTCFilterFunctionNArguments* args) { ((FilteredTrace*)args->context)->see(args); };
  }

  void see(const RTCFilterFunctionNArguments* args) {
    REQUIRE(++hits <= limits.most);
    const float t = ((const RTCRay*)args->ray)->tfar;
    const RTCHit& hit = *(const RTCHit*)args->hit;
    REQUIRE(hit.u >= limits.u && hit.v >= limits.v && std::isfinite(hit.u) && std::isfinite(hit.v));
    if (sound) REQUIRE(t >= tnear && t <= tfar);
    if (accepts) tfar = t;
    else args->valid[0] = 0;
  }
};

// intersect(ray, context): for a RayHit and a Ray; returns true if a hit was accepted.
template<typename Intersect>
void traceAndCompare(RTCScene scene, const RayBytes& bytes, const HitLimits& limits, const Intersect& intersect) {
  const bool sound = isSound(bytes);
  const Ray ray = bytes.ray();
  bool found[2];
  for (bool accepts : {true, false}) {
    FilteredTrace closest(limits, bytes, accepts);
    RayHit hit(ray);
    hit.geomID = RTC_INVALID_GEOMETRY_ID;
    IntersectContext context((Scene*)scene, &closest);
    intersect(hit, &context);
    REQUIRE((hit.geomID == 0) == (accepts && closest.hits));
    if (sound) REQUIRE(hit.tfar == (accepts ? closest.tfar : bytes.tfar));

    FilteredTrace any(limits, bytes, accepts);
    Ray occluded(ray);
    context.user = &any;
    const bool isOccluded = intersect(occluded, &context);
    REQUIRE(isOccluded == (accepts && any.hits));
    REQUIRE((closest.hits != 0) == (any.hits != 0));
    found[accepts] = any.hits;
  }
  REQUIRE(found[true] == found[false]);

  // without a filter, values that only filters receive are not computed
  RTCIntersectContext plain;
  rtcInitIntersectContext(&plain);
  IntersectContext context((Scene*)scene, &plain);
  Ray occluded(ray);
  REQUIRE(intersect(occluded, &context) == found[true]);
}

} // namespace programs::test
