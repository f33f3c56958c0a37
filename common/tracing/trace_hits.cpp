// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/trace_hits.h"
#include "tracing/closest_hits.h"

namespace cbvh {
namespace {

/* Rays of a call; a Vulkan device has threads of its own. */
constexpr size_t vulkanChunk = size_t(1) << 20;

size_t chunkOf(const BuiltScene& scene) { return scene.vulkan() ? vulkanChunk : raysAtOnce; }

} // namespace

void traceClosest(const BuiltScene& scene, size_t n, const Ray* rays, SurfaceHit* hits) { closestHits(scene, scene.tracer(), n, rays, hits); }

std::vector<SurfaceHit> traceClosest(const BuiltScene& scene, const std::vector<Ray>& rays, unsigned threads)
{
  return closestHits(scene, scene.tracer(), rays, chunkOf(scene), threads);
}

size_t countAnyHitDisagreements(const BuiltScene& scene, const std::vector<Ray>& rays,
                                const std::vector<SurfaceHit>& hits, unsigned threads)
{
  std::atomic<size_t> count{0};
  parallelFor(rays.size(), chunkOf(scene), threads, [&](size_t begin, size_t end) {
    const FastDenormals denormals;
    std::vector<RTCRay> batch(end - begin);
    for (size_t i = begin; i < end; i++)
      load(rays[i], batch[i - begin]);
    scene.tracer().occluded(batch.data(), batch.size());
    size_t local = 0;
    for (size_t i = begin; i < end; i++)
      local += (batch[i - begin].tfar < 0.0f) != hits[i].hit();
    count += local;
  });
  return count;
}

} // namespace cbvh
