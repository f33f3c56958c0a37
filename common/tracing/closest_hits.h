// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The loop of traceClosest, of any scene that says what traces it, and what its hits are. */

#include "basics/parallel.h"
#include "tracing/ray_conversion.h"

#include <vector>

namespace cbvh {

/* Rays that go to the processor at once. */
constexpr size_t raysAtOnce = 4096;

template<typename Scene>
void closestHits(const Scene& scene, const SceneTracer& tracer, size_t n, const Ray* rays, SurfaceHit* hits)
{
  const FastDenormals denormals;
  std::vector<RTCRayHit> batch(n);
  for (size_t i = 0; i < n; i++)
    load(rays[i], batch[i]);
  tracer.intersect(batch.data(), n);
  for (size_t i = 0; i < n; i++)
    hits[i] = scene.surfaceHit(batch[i]);
}

template<typename Scene>
std::vector<SurfaceHit> closestHits(const Scene& scene, const SceneTracer& tracer, const std::vector<Ray>& rays, size_t chunk, unsigned threads)
{
  std::vector<SurfaceHit> hits(rays.size());
  parallelFor(rays.size(), chunk, threads, [&](size_t begin, size_t end) { closestHits(scene, tracer, end - begin, &rays[begin], &hits[begin]); });
  return hits;
}

} // namespace cbvh
