// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Traces rays that a function returns, on the calling thread. Neither rays nor structs of Embree are stored for more
 * rays than a batch, which fits into the first-level cache; a Vulkan device gets all rays in one batch. */

#include "building/traced_scene.h"
#include "tracing/ray_conversion.h"

#include <algorithm>
#include <vector>

namespace programs {

constexpr size_t rayBatch = 64;

/* Rays per task of several threads. Vulkan devices need many. */
inline size_t rayChunk(const TracedScene& scene) { return scene.vulkan() ? size_t(1) << 20 : 4096; }

namespace batches {

/* Calls trace(batch, begin, end) for ranges that cover [0,n). */
template<typename RayType, typename Trace>
void forEach(const TracedScene& scene, size_t n, const Trace& trace) {
  const FlushDenormals denormals;
  if (scene.vulkan()) {
    std::vector<RayType> batch(n);
    trace(batch.data(), 0, n);
    return;
  }
  alignas(64) RayType batch[rayBatch];
  for (size_t i = 0; i < n; i += rayBatch) trace(batch, i, std::min(i + rayBatch, n));
}

} // namespace batches

/* Calls store(i, hit) for the SurfaceHit of rayAt(i), for all i in [0,n). Throws what they throw, and Error. */
template<typename RayAt, typename Store>
void traceClosestBatches(const TracedScene& scene, size_t n, const RayAt& rayAt, const Store& store) {
  batches::forEach<RTCRayHit>(scene, n, [&](RTCRayHit* batch, size_t begin, size_t end) {
    for (size_t i = begin; i < end; i++) load(rayAt(i), batch[i - begin]);
    scene.tracer().intersect(batch, end - begin);
    for (size_t i = begin; i < end; i++) store(i, scene.surfaceHit(batch[i - begin]));
  });
}

/* Calls store(i, isHit). A ray whose tfar is negative hits nothing. */
template<typename RayAt, typename Store>
void traceAnyBatches(const TracedScene& scene, size_t n, const RayAt& rayAt, const Store& store) {
  batches::forEach<RTCRay>(scene, n, [&](RTCRay* batch, size_t begin, size_t end) {
    std::vector<char> mayHit(end - begin);
    for (size_t i = begin; i < end; i++) {
      load(rayAt(i), batch[i - begin]);
      mayHit[i - begin] = !(batch[i - begin].tfar < 0.0f);
    }
    scene.tracer().occluded(batch, end - begin);
    for (size_t i = begin; i < end; i++) store(i, mayHit[i - begin] && batch[i - begin].tfar < 0.0f);
  });
}

} // namespace programs
