// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/trace_timing.h"
#include "basics/error.h"
#include "basics/progress.h"
#include "building/vulkan_tracer.h"
#include "tracing/trace_kernels.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <ctime>
#include <exception>
#include <thread>

namespace programs {
namespace {

struct HitCount {
  size_t hits = 0;

  void closest(size_t, const RTCRayHit& ray) { hits += ray.hit.geomID != RTC_INVALID_GEOMETRY_ID; }
  template<typename Packet>
  void closest(size_t, const Packet& packet, size_t lane) {
    hits += packet.hit.geomID[lane] != RTC_INVALID_GEOMETRY_ID;
  }
  void any(size_t, float tfar) { hits += tfar < 0.0f; }
};

double wallSeconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double threadSeconds() {
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

template<typename RayType, typename Trace, typename IsHit>
TraceTiming timeOnDevice(const std::vector<Ray>& rays, unsigned passes, const Trace& trace, const IsHit& isHit) {
  TraceTiming timing;
  std::vector<RayType> batch(rays.size());
  for (unsigned pass = 0; pass < passes; pass++) {
    for (size_t i = 0; i < rays.size(); i++) load(rays[i], batch[i]);
    timing.seconds += trace(batch.data(), batch.size()) / double(passes);
    throwIfCanceled();
  }
  if (!rays.empty() && !(timing.seconds > 0.0))
    throw Error("measuring speed: the Vulkan device has no clock; expected a device with timestamps");
  timing.hits = size_t(std::count_if(batch.begin(), batch.end(), isHit));
  return timing;
}

TraceTiming timeOnDevice(const VulkanTracer& tracer, const std::vector<Ray>& rays, const TraceSettings& settings) {
  if (settings.query == Closest)
    return timeOnDevice<RTCRayHit>(
        rays, settings.passes, [&](RTCRayHit* batch, size_t n) { return tracer.timeIntersect(batch, n); },
        [](const RTCRayHit& ray) { return ray.hit.geomID != RTC_INVALID_GEOMETRY_ID; });
  return timeOnDevice<RTCRay>(
      rays, settings.passes, [&](RTCRay* batch, size_t n) { return tracer.timeOccluded(batch, n); },
      [](const RTCRay& ray) { return ray.tfar < 0.0f; });
}

} // namespace

TraceTiming timeTrace(const TracedScene& scene, const std::vector<Ray>& rays, const TraceSettings& settings) {
  if (scene.vulkan()) return timeOnDevice(*scene.vulkan(), rays, settings);
  const Kernel<HitCount> kernel = kernelOf<HitCount>(settings.mode, settings.query);
  const size_t chunks = (rays.size() + traceChunk - 1) / traceChunk;
  std::atomic<size_t> next{0}, hits{0};
  std::atomic<unsigned> waiting{0};
  std::atomic<bool> go{false};
  const Cancellation* const cancellation = CancellationScope::current();
  const auto work = [&] {
    const CancellationScope scope(cancellation);
    const FlushDenormals denormals;
    RTCIntersectContext context = traceContext(settings.coherent);
    size_t count = 0;
    for (size_t i; !cancelRequested() && (i = next++) < chunks * settings.passes;) {
      const size_t begin = i % chunks * traceChunk;
      count += kernel(scene.handle(), context, &rays[begin], std::min(traceChunk, rays.size() - begin), {}).hits;
    }
    hits += count;
  };
  const size_t useful = std::min(size_t(settings.threads), chunks * settings.passes);
  std::vector<std::thread> pool;
  try {
    for (size_t i = 1; i < useful; i++)
      pool.emplace_back([&] {
        waiting++;
        while (!go) std::this_thread::yield();
        work();
      });
  } catch (const std::exception& e) // a limit of the system
  {
    next = chunks * settings.passes; // no work
    go = true;
    for (std::thread& t : pool) t.join();
    throw Error("measuring speed: cannot start " + std::to_string(settings.threads) + " threads: " + e.what() +
                "; expected at most " + std::to_string(pool.size() + 1));
  }
  while (waiting < pool.size()) std::this_thread::yield();
  const auto clock = settings.threads > 1 ? wallSeconds : threadSeconds;
  const double start = clock();
  go = true;
  work();
  for (std::thread& t : pool) t.join();
  TraceTiming timing;
  timing.seconds = (clock() - start) / double(settings.passes);
  timing.hits = hits / settings.passes;
  throwIfCanceled();
  return timing;
}

} // namespace programs
