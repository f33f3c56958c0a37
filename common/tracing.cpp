// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing.h"
#include "parallel.h"

#include <chrono>
#include <pmmintrin.h>
#include <xmmintrin.h>

namespace cbvh {
namespace {

/* Denormals off while tracing, as Embree's manual asks for. */
class FastDenormals
{
public:
  FastDenormals() : saved(_mm_getcsr())
  {
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  }
  ~FastDenormals() { _mm_setcsr(saved); }

private:
  unsigned saved;
};

inline void load(const Ray& ray, RTCRay& out)
{
  out.org_x = ray.origin.x;
  out.org_y = ray.origin.y;
  out.org_z = ray.origin.z;
  out.tnear = ray.tnear;
  out.dir_x = ray.direction.x;
  out.dir_y = ray.direction.y;
  out.dir_z = ray.direction.z;
  out.time = 0.0f;
  out.tfar = ray.tfar;
  out.mask = ~0u;
  out.id = 0;
  out.flags = 0;
}

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

template<typename Trace>
double timed(const std::vector<Ray>& rays, const Trace& trace)
{
  const FastDenormals denormals;
  const auto start = std::chrono::steady_clock::now();
  size_t count = 0;
  for (size_t begin = 0; begin < rays.size(); begin += chunk)
  {
    throwIfCancelled();
    for (size_t i = begin; i < std::min(begin + chunk, rays.size()); i++)
      count += trace(rays[i]);
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  static volatile size_t sink; // the results must be used
  sink = count;
  (void)sink;
  return seconds;
}

} // namespace

std::vector<SurfaceHit> traceClosest(const BuiltScene& scene, const std::vector<Ray>& rays, unsigned threads)
{
  std::vector<SurfaceHit> hits(rays.size());
  parallelFor(rays.size(), chunk, threads, [&](size_t begin, size_t end) {
    const FastDenormals denormals;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = begin; i < end; i++)
    {
      RTCRayHit ray;
      closest(scene, context, rays[i], ray);
      hits[i] = scene.surfaceHit(ray);
    }
  });
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

double timeClosest(const BuiltScene& scene, const std::vector<Ray>& rays)
{
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return timed(rays, [&](const Ray& r) {
    RTCRayHit ray;
    closest(scene, context, r, ray);
    return size_t(ray.hit.geomID != RTC_INVALID_GEOMETRY_ID);
  });
}

double timeAny(const BuiltScene& scene, const std::vector<Ray>& rays)
{
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  return timed(rays, [&](const Ray& r) { return size_t(any(scene, context, r)); });
}

} // namespace cbvh
