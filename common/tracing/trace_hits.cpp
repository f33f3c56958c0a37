// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/trace_hits.h"
#include "basics/parallel.h"
#include "tracing/ray_conversion.h"

namespace cbvh {
namespace {

inline void closest(const BuiltScene& scene, RTCIntersectContext& context, const Ray& ray, RTCRayHit& out)
{
  load(ray, out.ray);
  out.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  out.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene.handle(), &context, &out);
}

inline bool any(const BuiltScene& scene, RTCIntersectContext& context, const Ray& ray)
{
  RTCRay out;
  load(ray, out);
  rtcOccluded1(scene.handle(), &context, &out);
  return out.tfar < 0.0f;
}

constexpr size_t chunk = 4096;

} // namespace

void traceClosest(const BuiltScene& scene, size_t n, const Ray* rays, SurfaceHit* hits)
{
  const FastDenormals denormals;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  for (size_t i = 0; i < n; i++)
  {
    RTCRayHit ray;
    closest(scene, context, rays[i], ray);
    hits[i] = scene.surfaceHit(ray);
  }
}

std::vector<SurfaceHit> traceClosest(const BuiltScene& scene, const std::vector<Ray>& rays, unsigned threads)
{
  std::vector<SurfaceHit> hits(rays.size());
  parallelFor(rays.size(), chunk, threads,
              [&](size_t begin, size_t end) { traceClosest(scene, end - begin, &rays[begin], &hits[begin]); });
  return hits;
}

size_t countAnyHitDisagreements(const BuiltScene& scene, const std::vector<Ray>& rays,
                                const std::vector<SurfaceHit>& hits, unsigned threads)
{
  std::atomic<size_t> count{0};
  parallelFor(rays.size(), chunk, threads, [&](size_t begin, size_t end) {
    const FastDenormals denormals;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    size_t local = 0;
    for (size_t i = begin; i < end; i++)
      local += any(scene, context, rays[i]) != hits[i].hit();
    count += local;
  });
  return count;
}

} // namespace cbvh
