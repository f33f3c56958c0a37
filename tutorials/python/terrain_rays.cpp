// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "terrain.h"

#include "basics/parallel.h"
#include "tracing/trace_batches.h"
#include "tracing/trace_hits.h"

#include <cmath>

namespace programs::python {
namespace {

Georeference::SceneRay rayOf(const Georeference& space, const RayArrays& rays, size_t i, const Box3f& box) {
  return space.ray(rays.origins.vectorAt<double>(i), rays.directions.vectorAt<double>(i), rays.tnear.at<double>(i),
                   rays.tfar.at<double>(i), box);
}

} // namespace

void Terrain::intersect(const RayArrays& rays, unsigned threads, TerrainHit* hits) const {
  const Box3f box = scene->bounds();
  parallelFor(rays.count, rayChunk(*scene), threads, [&](size_t begin, size_t end) {
    std::vector<Georeference::SceneRay> converted(end - begin);
    const auto rayAt = [&](size_t i) -> const Ray& { return (converted[i] = rayOf(space, rays, begin + i, box)).ray; };
    const auto store = [&](size_t i, const SurfaceHit& hit) {
      TerrainHit out;
      if (hit.hit()) {
        const Georeference::SceneRay& ray = converted[i];
        out.t = ray.start + ray.scale * double(hit.t);
        out.position = rays.origins.vectorAt<double>(begin + i) + out.t * rays.directions.vectorAt<double>(begin + i);
        out.normal = space.normal(hit.normal);
      }
      hits[begin + i] = out;
    };
    traceClosestBatches(*scene, end - begin, rayAt, store);
  });
  errors.check(*scene);
}

void Terrain::occluded(const RayArrays& rays, unsigned threads, bool* hits) const {
  const Box3f box = scene->bounds();
  parallelFor(rays.count, rayChunk(*scene), threads, [&](size_t begin, size_t end) {
    traceAnyBatches(
        *scene, end - begin, [&](size_t i) { return rayOf(space, rays, begin + i, box).ray; },
        [&](size_t i, bool isHit) { hits[begin + i] = isHit; });
  });
  errors.check(*scene);
}

/* A terrain without overhangs occludes every ray below its horizon: bisection finds it. */
std::vector<float> Terrain::horizons(const std::vector<Vec3d>& points, const std::vector<double>& azimuths,
                                     double accuracy, unsigned threads) const {
  const Box3f box = scene->bounds();
  const size_t n = azimuths.size();
  const int steps = std::max(0, int(std::ceil(std::log2(180 / accuracy))));
  const double radians = M_PI / 180;
  std::vector<float> result(points.size() * n);
  parallelFor(points.size(), 16, threads, [&](size_t begin, size_t end) {
    std::vector<double> low(n), high(n);
    std::vector<Ray> rays(n);
    std::vector<char> hit(n);
    for (size_t i = begin; i < end; i++) {
      low.assign(n, -90.0);
      high.assign(n, 90.0);
      for (int step = 0; step < steps; step++) {
        for (size_t j = 0; j < n; j++) {
          const double elevation = 0.5 * (low[j] + high[j]) * radians, azimuth = azimuths[j] * radians;
          const double across = std::cos(elevation);
          const Vec3d direction{std::sin(azimuth) * across, std::cos(azimuth) * across, std::sin(elevation)};
          rays[j] = space.ray(points[i], direction, 0, INFINITY, box).ray;
        }
        traceAny(*scene, n, rays.data(), hit.data());
        for (size_t j = 0; j < n; j++) (hit[j] ? low : high)[j] = 0.5 * (low[j] + high[j]);
      }
      for (size_t j = 0; j < n; j++) result[i * n + j] = float(0.5 * (low[j] + high[j]));
    }
  });
  errors.check(*scene);
  return result;
}

} // namespace programs::python
