// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The C++ side of scripts/measure_python.py: traces rays of arrays, as a program would do that uses Embree's functions.
 *
 *   cbvh_ray_arrays FILE RAYS
 *
 * FILE is a saved scene. RAYS contains float32: x, y, z of all origins, then of all directions. For each line
 * "closest THREADS" or "any THREADS" of the standard input, traces all rays with rtcIntersect1 or rtcOccluded1, stores
 * the results in arrays, and prints wall-clock and processor time in seconds. */

#include "basics/error.h"
#include "basics/parallel.h"
#include "basics/seconds.h"
#include "building/saved_scene.h"
#include "tracing/denormals.h"

#include <cstdio>
#include <ctime>
#include <fstream>
#include <iostream>
#include <string>
#include <vector>

namespace programs { namespace {

constexpr size_t chunk = 4096;

struct RayArrays {
  explicit RayArrays(const std::string& path) {
    std::ifstream file(path, std::ios::binary | std::ios::ate);
    if (!file) throw Error(path + ": cannot be opened");
    values.resize(size_t(file.tellg()) / sizeof(float));
    file.seekg(0);
    file.read(reinterpret_cast<char*>(values.data()), std::streamsize(values.size() * sizeof(float)));
  }

  size_t count() const { return values.size() / 6; }
  const float* origin(size_t i) const { return &values[3 * i]; }
  const float* direction(size_t i) const { return &values[3 * (count() + i)]; }

  std::vector<float> values;
};

struct HitArrays {
  explicit HitArrays(size_t n) : t(n), u(n), v(n), Ng(3 * n), primID(n), geomID(n), isHit(n) {}

  std::vector<float> t, u, v, Ng;
  std::vector<unsigned> primID, geomID;
  std::vector<char> isHit;
};

RTCRay rayOf(const RayArrays& rays, size_t i) {
  const float *const o = rays.origin(i), *const d = rays.direction(i);
  return {o[0], o[1], o[2], 0, d[0], d[1], d[2], 0, INFINITY, ~0u, 0, 0};
}

void intersect(RTCScene scene, RTCIntersectContext& context, const RayArrays& rays, size_t i, HitArrays& out) {
  RTCRayHit ray;
  ray.ray = rayOf(rays, i);
  ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  rtcIntersect1(scene, &context, &ray);
  const bool isHit = ray.hit.geomID != RTC_INVALID_GEOMETRY_ID;
  out.t[i] = ray.ray.tfar;
  out.u[i] = isHit ? ray.hit.u : 0;
  out.v[i] = isHit ? ray.hit.v : 0;
  out.Ng[3 * i] = isHit ? ray.hit.Ng_x : 0;
  out.Ng[3 * i + 1] = isHit ? ray.hit.Ng_y : 0;
  out.Ng[3 * i + 2] = isHit ? ray.hit.Ng_z : 0;
  out.primID[i] = isHit ? ray.hit.primID : RTC_INVALID_GEOMETRY_ID;
  out.geomID[i] = ray.hit.geomID;
}

void trace(RTCScene scene, const RayArrays& rays, bool any, unsigned threads, HitArrays& out) {
  parallelFor(rays.count(), chunk, threads, [&](size_t begin, size_t end) {
    const FlushDenormals denormals;
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (size_t i = begin; i < end; i++) {
      if (!any) intersect(scene, context, rays, i, out);
      else {
        RTCRay ray = rayOf(rays, i);
        rtcOccluded1(scene, &context, &ray);
        out.isHit[i] = ray.tfar < 0;
      }
    }
  });
}

int run(const std::string& file, const std::string& raysPath) {
  const SavedScene scene(file, threadCount(0));
  const RayArrays rays(raysPath);
  HitArrays hits(rays.count());
  std::string query;
  for (unsigned threads; std::cin >> query >> threads;) {
    const std::clock_t start = std::clock();
    const double wall = secondsOf([&] { trace(scene.handle(), rays, query == "any", threads, hits); });
    std::printf("%.9g %.9g\n", wall, double(std::clock() - start) / CLOCKS_PER_SEC);
    std::fflush(stdout);
  }
  return 0;
}

}} // namespace programs

int main(int argc, char** argv) {
  if (argc != 3) {
    std::fputs("usage: cbvh_ray_arrays FILE RAYS\n", stderr);
    return 2;
  }
  try {
    return programs::run(argv[1], argv[2]);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "cbvh_ray_arrays: %s\n", e.what());
    return 1;
  }
}
