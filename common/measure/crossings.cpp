// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "measure/crossings.h"
#include "basics/parallel.h"
#include "tracing/ray_conversion.h"

#include <mutex>

namespace programs {
namespace {

struct CountingContext : RTCIntersectContext {
  size_t crossings = 0;

  CountingContext() {
    rtcInitIntersectContext(this);
    filter = [](const RTCFilterFunctionNArguments* args) {
      static_cast<CountingContext*>(args->context)->crossings++;
      args->valid[0] = 0;
    };
  }
};

size_t crossingsOf(const BuiltScene& scene, const Ray& ray) {
  CountingContext context;
  RTCRayHit out;
  load(ray, out.ray);
  out.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  out.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene.handle(), &context, &out);
  return context.crossings;
}

} // namespace

CrossingCounts countCrossings(const BuiltScene& grid, const BuiltScene& scene, const std::vector<Ray>& rays,
                              unsigned threads) {
  CrossingCounts all;
  std::mutex mutex;
  parallelFor(rays.size(), 4096, threads, [&](size_t begin, size_t end) {
    const FlushDenormals denormals;
    CrossingCounts counts;
    for (size_t i = begin; i < end; i++) {
      const size_t inScene = crossingsOf(scene, rays[i]), inGrid = crossingsOf(grid, rays[i]);
      counts.rays++;
      counts.sceneCrossings += inScene;
      counts.gridCrossings += inGrid;
      counts.differentCounts += inScene != inGrid;
      counts.differentParities += inScene % 2 != inGrid % 2;
    }
    const std::lock_guard<std::mutex> lock(mutex);
    all.rays += counts.rays;
    all.sceneCrossings += counts.sceneCrossings;
    all.gridCrossings += counts.gridCrossings;
    all.differentCounts += counts.differentCounts;
    all.differentParities += counts.differentParities;
  });
  return all;
}

} // namespace programs
