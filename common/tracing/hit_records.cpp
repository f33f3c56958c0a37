// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/hit_records.h"
#include "basics/parallel.h"
#include "tracing/trace_kernels.h"

#include <cmath>

namespace programs {
namespace {

/* Embree does not write to rays that miss. */
struct HitStore {
  HitRecord* hits;

  void closest(size_t i, const RTCRayHit& ray) {
    if (ray.hit.geomID != RTC_INVALID_GEOMETRY_ID)
      hits[i] = {true,         ray.hit.geomID, ray.hit.primID, ray.hit.instID[0],
                 ray.ray.tfar, ray.hit.u,      ray.hit.v,      {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z}};
  }
  template<typename Packet>
  void closest(size_t i, const Packet& packet, size_t k) {
    const auto& hit = packet.hit;
    if (hit.geomID[k] != RTC_INVALID_GEOMETRY_ID)
      hits[i] = {true,
                 hit.geomID[k],
                 hit.primID[k],
                 hit.instID[0][k],
                 packet.ray.tfar[k],
                 hit.u[k],
                 hit.v[k],
                 {hit.Ng_x[k], hit.Ng_y[k], hit.Ng_z[k]}};
  }
  void any(size_t i, float tfar) { hits[i].hit = tfar < 0.0f; }
};

bool same(float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }

bool sameIds(const HitRecord& a, const HitRecord& b) {
  return a.geometry == b.geometry && a.primitive == b.primitive && a.instance == b.instance;
}

bool sameSurface(const HitRecord& a, const HitRecord& b) {
  return same(a.u, b.u) && same(a.v, b.v) && same(a.normal.x, b.normal.x) && same(a.normal.y, b.normal.y) &&
         same(a.normal.z, b.normal.z);
}

} // namespace

std::vector<HitRecord> recordHits(const TracedScene& scene, const std::vector<Ray>& rays,
                                  const TraceSettings& settings) {
  std::vector<HitRecord> hits(rays.size());
  const Kernel<HitStore> kernel = kernelOf<HitStore>(settings.mode, settings.query);
  parallelFor(rays.size(), traceChunk, settings.threads, [&](size_t begin, size_t end) {
    const FlushDenormals denormals;
    RTCIntersectContext context = traceContext(settings.coherent);
    kernel(scene.handle(), context, &rays[begin], end - begin, {&hits[begin]});
  });
  return hits;
}

HitDifferences compareHitRecords(const std::vector<HitRecord>& a, const std::vector<HitRecord>& b) {
  HitDifferences found;
  found.rays = a.size();
  for (size_t i = 0; i < a.size(); i++)
    if (a[i].hit != b[i].hit) found.hits++;
    else if (!sameIds(a[i], b[i])) found.ids++;
    else if (!same(a[i].t, b[i].t)) found.distances++;
    else if (!sameSurface(a[i], b[i])) found.surfaces++;
  return found;
}

} // namespace programs
