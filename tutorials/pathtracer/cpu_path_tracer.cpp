// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Traces the paths of path.h with Embree, as the reference for Vulkan devices. */

#include "path_tracer.h"
#include "basics/parallel.h"
#include "tracing/ray_conversion.h"

namespace programs {
namespace path {
namespace {

Ray rayOf(vec3 origin, float tnear, vec3 direction, float time) {
  Ray ray;
  ray.origin = origin;
  ray.tnear = tnear;
  ray.direction = direction;
  ray.time = time;
  return ray;
}

} // namespace

ClosestHit closestHit(TracedScene scene, vec3 origin, float tnear, vec3 direction, float time) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRayHit ray;
  load(rayOf(origin, tnear, direction, time), ray.ray);
  ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene, &context, &ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {false, INFINITY, {}};
  return {true, ray.ray.tfar, {ray.hit.Ng_x, ray.hit.Ng_y, ray.hit.Ng_z}};
}

bool isOccluded(TracedScene scene, vec3 origin, float tnear, vec3 direction, float time) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  RTCRay ray;
  load(rayOf(origin, tnear, direction, time), ray);
  rtcOccluded1(scene, &context, &ray);
  return ray.tfar < 0.0f;
}

} // namespace path

namespace {

constexpr size_t chunk = 1024; // pixels

class CpuPathTracer : public PathTracer {
public:
  CpuPathTracer(RTCScene scene, const PathView& view, unsigned threads)
    : scene(scene),
      view(view),
      threads(threads),
      light(size_t(view.width) * view.height) {}

  std::string deviceName() const override {
    return std::to_string(threads) + (threads == 1 ? " thread" : " threads") + " of the CPU";
  }

private:
  void addSample(uint32_t sampleIndex) override {
    parallelFor(light.size(), chunk, threads, [&](size_t begin, size_t end) {
      const FlushDenormals denormals;
      for (size_t i = begin; i < end; i++)
        light[i] += path::lightOfPath(scene, view, uint32_t(i % view.width), uint32_t(i / view.width), sampleIndex);
    });
  }

  std::vector<Vec3f> sums() const override { return light; }

  RTCScene scene;
  PathView view;
  unsigned threads;
  std::vector<Vec3f> light;
};

} // namespace

std::unique_ptr<PathTracer> makeCpuPathTracer(RTCScene scene, const PathView& view, unsigned threads) {
  return std::make_unique<CpuPathTracer>(scene, view, threads);
}

} // namespace programs
