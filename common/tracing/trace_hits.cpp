// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/trace_hits.h"
#include "basics/parallel.h"
#include "tracing/ray_conversion.h"

namespace programs {
namespace {

/* Rays per call; Vulkan devices need many. */
constexpr size_t embreeChunk = 4096, vulkanChunk = size_t(1) << 20;

size_t chunkOf(const TracedScene& scene) { return scene.vulkan() ? vulkanChunk : embreeChunk; }

} // namespace

void traceClosest(const TracedScene& scene, size_t n, const Ray* rays, SurfaceHit* hits) {
  const FlushDenormals denormals;
  std::vector<RTCRayHit> batch(n);
  for (size_t i = 0; i < n; i++) load(rays[i], batch[i]);
  scene.tracer().intersect(batch.data(), n);
  for (size_t i = 0; i < n; i++) hits[i] = scene.surfaceHit(batch[i]);
}

void traceAny(const TracedScene& scene, size_t n, const Ray* rays, char* hits) {
  const FlushDenormals denormals;
  std::vector<RTCRay> batch(n);
  for (size_t i = 0; i < n; i++) load(rays[i], batch[i]);
  scene.tracer().occluded(batch.data(), n);
  for (size_t i = 0; i < n; i++) hits[i] = batch[i].tfar < 0.0f && !(rays[i].tfar < 0.0f);
}

std::vector<SurfaceHit> traceClosest(const TracedScene& scene, const std::vector<Ray>& rays, unsigned threads) {
  std::vector<SurfaceHit> hits(rays.size());
  parallelFor(rays.size(), chunkOf(scene), threads,
              [&](size_t begin, size_t end) { traceClosest(scene, end - begin, &rays[begin], &hits[begin]); });
  return hits;
}

size_t countAnyHitDisagreements(const TracedScene& scene, const std::vector<Ray>& rays,
                                const std::vector<SurfaceHit>& hits, unsigned threads) {
  std::atomic<size_t> count{0};
  parallelFor(rays.size(), chunkOf(scene), threads, [&](size_t begin, size_t end) {
    const FlushDenormals denormals;
    std::vector<RTCRay> batch(end - begin);
    for (size_t i = begin; i < end; i++) load(rays[i], batch[i - begin]);
    scene.tracer().occluded(batch.data(), batch.size());
    size_t local = 0;
    for (size_t i = begin; i < end; i++) local += (batch[i - begin].tfar < 0.0f) != hits[i].hit();
    count += local;
  });
  return count;
}

} // namespace programs
