// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/trace_hits.h"
#include "basics/parallel.h"
#include "tracing/trace_batches.h"

namespace programs {

void traceClosest(const TracedScene& scene, size_t n, const Ray* rays, SurfaceHit* hits) {
  traceClosestBatches(
      scene, n, [&](size_t i) -> const Ray& { return rays[i]; },
      [&](size_t i, const SurfaceHit& hit) { hits[i] = hit; });
}

void traceAny(const TracedScene& scene, size_t n, const Ray* rays, char* hits) {
  traceAnyBatches(
      scene, n, [&](size_t i) -> const Ray& { return rays[i]; }, [&](size_t i, bool isHit) { hits[i] = isHit; });
}

std::vector<SurfaceHit> traceClosest(const TracedScene& scene, const std::vector<Ray>& rays, unsigned threads) {
  std::vector<SurfaceHit> hits(rays.size());
  parallelFor(rays.size(), rayChunk(scene), threads,
              [&](size_t begin, size_t end) { traceClosest(scene, end - begin, &rays[begin], &hits[begin]); });
  return hits;
}

size_t countAnyHitDisagreements(const TracedScene& scene, const std::vector<Ray>& rays,
                                const std::vector<SurfaceHit>& hits, unsigned threads) {
  std::atomic<size_t> count{0};
  parallelFor(rays.size(), rayChunk(scene), threads, [&](size_t begin, size_t end) {
    size_t local = 0;
    traceAnyBatches(
        scene, end - begin, [&](size_t i) -> const Ray& { return rays[begin + i]; },
        [&](size_t i, bool isHit) { local += isHit != hits[begin + i].hit(); });
    count += local;
  });
  return count;
}

} // namespace programs
