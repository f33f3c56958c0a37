// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/trace_timing.h"
#include "basics/error.h"
#include "basics/progress.h"
#include "tracing/ray_conversion.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <ctime>
#include <thread>

namespace cbvh {
namespace {

constexpr const char* queryNames[numQueries] = {"closest", "any"};
constexpr const char* modeNames[] = {"single", "packet4", "packet8", "packet16", "stream"};

/* Each traces rays [0,n) and returns how many hit. */
using Kernel = size_t (*)(RTCScene, RTCIntersectContext&, const Ray*, size_t n);

size_t closestSingle(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n)
{
  size_t hits = 0;
  for (size_t i = 0; i < n; i++)
  {
    RTCRayHit ray;
    load(rays[i], ray.ray);
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene, &context, &ray);
    hits += ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }
  return hits;
}

size_t anySingle(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n)
{
  size_t hits = 0;
  for (size_t i = 0; i < n; i++)
  {
    RTCRay ray;
    load(rays[i], ray);
    rtcOccluded1(scene, &context, &ray);
    hits += ray.tfar < 0.0f;
  }
  return hits;
}

struct Packet4
{
  static constexpr size_t size = 4;
  using Ray = RTCRay4;
  using RayHit = RTCRayHit4;
  static void closest(const int* valid, RTCScene s, RTCIntersectContext* c, RayHit* r) { rtcIntersect4(valid, s, c, r); }
  static void any(const int* valid, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded4(valid, s, c, r); }
};

struct Packet8
{
  static constexpr size_t size = 8;
  using Ray = RTCRay8;
  using RayHit = RTCRayHit8;
  static void closest(const int* valid, RTCScene s, RTCIntersectContext* c, RayHit* r) { rtcIntersect8(valid, s, c, r); }
  static void any(const int* valid, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded8(valid, s, c, r); }
};

struct Packet16
{
  static constexpr size_t size = 16;
  using Ray = RTCRay16;
  using RayHit = RTCRayHit16;
  static void closest(const int* valid, RTCScene s, RTCIntersectContext* c, RayHit* r)
  {
    rtcIntersect16(valid, s, c, r);
  }
  static void any(const int* valid, RTCScene s, RTCIntersectContext* c, Ray* r) { rtcOccluded16(valid, s, c, r); }
};

/* Lanes beyond n repeat the last ray, inactive. */
template<typename Packet, typename PacketRay>
size_t loadPacket(const Ray* rays, size_t n, PacketRay& packet, int* valid)
{
  const size_t active = std::min(n, Packet::size);
  for (size_t i = 0; i < Packet::size; i++)
  {
    valid[i] = i < active ? -1 : 0;
    load(rays[std::min(i, active - 1)], packet, i);
  }
  return active;
}

template<typename Packet>
size_t closestPackets(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n)
{
  size_t hits = 0;
  alignas(64) int valid[Packet::size];
  alignas(64) typename Packet::RayHit packet;
  for (size_t i = 0; i < n; i += Packet::size)
  {
    const size_t active = loadPacket<Packet>(rays + i, n - i, packet.ray, valid);
    for (size_t k = 0; k < Packet::size; k++)
    {
      packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
      packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    Packet::closest(valid, scene, &context, &packet);
    for (size_t k = 0; k < active; k++)
      hits += packet.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
  }
  return hits;
}

template<typename Packet>
size_t anyPackets(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n)
{
  size_t hits = 0;
  alignas(64) int valid[Packet::size];
  alignas(64) typename Packet::Ray packet;
  for (size_t i = 0; i < n; i += Packet::size)
  {
    const size_t active = loadPacket<Packet>(rays + i, n - i, packet, valid);
    Packet::any(valid, scene, &context, &packet);
    for (size_t k = 0; k < active; k++)
      hits += packet.tfar[k] < 0.0f;
  }
  return hits;
}

size_t closestStreams(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n)
{
  size_t hits = 0;
  alignas(64) RTCRayHit stream[streamSize];
  for (size_t i = 0; i < n; i += streamSize)
  {
    const size_t active = std::min(n - i, streamSize);
    for (size_t k = 0; k < active; k++)
    {
      load(rays[i + k], stream[k].ray);
      stream[k].hit.geomID = RTC_INVALID_GEOMETRY_ID;
      stream[k].hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect1M(scene, &context, stream, unsigned(active), sizeof(RTCRayHit));
    for (size_t k = 0; k < active; k++)
      hits += stream[k].hit.geomID != RTC_INVALID_GEOMETRY_ID;
  }
  return hits;
}

size_t anyStreams(RTCScene scene, RTCIntersectContext& context, const Ray* rays, size_t n)
{
  size_t hits = 0;
  alignas(64) RTCRay stream[streamSize];
  for (size_t i = 0; i < n; i += streamSize)
  {
    const size_t active = std::min(n - i, streamSize);
    for (size_t k = 0; k < active; k++)
      load(rays[i + k], stream[k]);
    rtcOccluded1M(scene, &context, stream, unsigned(active), sizeof(RTCRay));
    for (size_t k = 0; k < active; k++)
      hits += stream[k].tfar < 0.0f;
  }
  return hits;
}

Kernel kernelOf(TraceMode mode, Query query)
{
  const bool closest = query == Closest;
  switch (mode)
  {
  case TraceMode::Packet4: return closest ? closestPackets<Packet4> : anyPackets<Packet4>;
  case TraceMode::Packet8: return closest ? closestPackets<Packet8> : anyPackets<Packet8>;
  case TraceMode::Packet16: return closest ? closestPackets<Packet16> : anyPackets<Packet16>;
  case TraceMode::Stream: return closest ? closestStreams : anyStreams;
  default: return closest ? closestSingle : anySingle;
  }
}

double wallSeconds()
{
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double threadSeconds()
{
  timespec time;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

} // namespace

const char* queryName(Query query)
{
  return queryNames[query];
}

const char* traceModeName(TraceMode mode)
{
  return modeNames[size_t(mode)];
}

Query parseQuery(const std::string& name)
{
  for (int i = 0; i < numQueries; i++)
    if (name == queryNames[i])
      return Query(i);
  throw Error("unknown query '" + name + "', known are closest and any");
}

TraceMode parseTraceMode(const std::string& name)
{
  for (size_t i = 0; i < std::size(modeNames); i++)
    if (name == modeNames[i])
      return TraceMode(i);
  throw Error("unknown mode '" + name + "', known are single, packet4, packet8, packet16 and stream");
}

namespace {

template<typename RayType, typename Trace, typename IsHit>
TraceTiming timeOnDevice(const std::vector<Ray>& rays, unsigned passes, const Trace& trace, const IsHit& isHit)
{
  TraceTiming timing;
  std::vector<RayType> batch(rays.size());
  for (unsigned pass = 0; pass < passes; pass++)
  {
    for (size_t i = 0; i < rays.size(); i++)
      load(rays[i], batch[i]);
    timing.seconds += trace(batch.data(), batch.size()) / double(passes);
    throwIfCancelled();
  }
  timing.hits = size_t(std::count_if(batch.begin(), batch.end(), isHit));
  return timing;
}

TraceTiming timeOnDevice(const VulkanTracer& tracer, const std::vector<Ray>& rays, const TraceSettings& settings)
{
  if (settings.query == Closest)
    return timeOnDevice<RTCRayHit>(
      rays, settings.passes, [&](RTCRayHit* batch, size_t n) { return tracer.timeIntersect(batch, n); },
      [](const RTCRayHit& ray) { return ray.hit.geomID != RTC_INVALID_GEOMETRY_ID; });
  return timeOnDevice<RTCRay>(
    rays, settings.passes, [&](RTCRay* batch, size_t n) { return tracer.timeOccluded(batch, n); },
    [](const RTCRay& ray) { return ray.tfar < 0.0f; });
}

} // namespace

TraceTiming timeTrace(const BuiltScene& scene, const std::vector<Ray>& rays, const TraceSettings& settings)
{
  if (scene.vulkan())
    return timeOnDevice(*scene.vulkan(), rays, settings);
  constexpr size_t chunk = 4096; // whole packets and streams, and 64 tiles of 8 x 8
  static_assert(chunk % streamSize == 0, "only the last call of a set is not full");
  const Kernel kernel = kernelOf(settings.mode, settings.query);
  const size_t chunks = (rays.size() + chunk - 1) / chunk;
  std::atomic<size_t> next{0}, hits{0};
  std::atomic<unsigned> waiting{0};
  std::atomic<bool> go{false};
  const auto work = [&] {
    const FastDenormals denormals;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = settings.coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    size_t count = 0;
    for (size_t i; !cancelRequested() && (i = next++) < chunks * settings.passes;)
    {
      const size_t begin = i % chunks * chunk;
      count += kernel(scene.handle(), context, &rays[begin], std::min(chunk, rays.size() - begin));
    }
    hits += count;
  };
  std::vector<std::thread> pool;
  for (unsigned i = 1; i < settings.threads; i++)
    pool.emplace_back([&] {
      waiting++;
      while (!go)
        std::this_thread::yield();
      work();
    });
  while (waiting < pool.size())
    std::this_thread::yield();
  const auto clock = settings.threads > 1 ? wallSeconds : threadSeconds;
  const double start = clock();
  go = true;
  work();
  for (std::thread& t : pool)
    t.join();
  TraceTiming timing;
  timing.seconds = (clock() - start) / double(settings.passes);
  timing.hits = hits / settings.passes;
  throwIfCancelled();
  return timing;
}

} // namespace cbvh
