// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "terrain.h"

#include "basics/parallel.h"
#include "tracing/trace_hits.h"

#include <cmath>

namespace programs::python {
namespace {

constexpr size_t chunk = 4096; // rays

Vec3d vectorAt(const RayArrays<double>::Array& array, size_t i) {
  const double* const v = array.data() + 3 * i;
  return {v[0], v[1], v[2]};
}

Georeference::SceneRay rayOf(const Georeference& space, const RayArrays<double>& rays, size_t i, const Box3f& box) {
  return space.ray(vectorAt(rays.origins, i), vectorAt(rays.directions, i), rays.tnear.data()[i], rays.tfar.data()[i],
                   box);
}

} // namespace

TerrainHits Terrain::intersect(const RayArrays<double>& rays, unsigned threads) const {
  const Box3f box = scene->bounds();
  TerrainHits result(rays.shape, space);
  result.hits.resize(size_t(rays.tnear.size()));
  parallelFor(result.hits.size(), chunk, threads, [&](size_t begin, size_t end) {
    std::vector<Georeference::SceneRay> converted(end - begin);
    std::vector<Ray> batch(end - begin);
    std::vector<SurfaceHit> hits(end - begin);
    for (size_t i = begin; i < end; i++) batch[i - begin] = (converted[i - begin] = rayOf(space, rays, i, box)).ray;
    traceClosest(*scene, end - begin, batch.data(), hits.data());
    for (size_t i = begin; i < end; i++) {
      const SurfaceHit& hit = hits[i - begin];
      if (!hit.hit()) continue;
      const Georeference::SceneRay& ray = converted[i - begin];
      TerrainHit& out = result.hits[i];
      out.t = ray.start + ray.scale * double(hit.t);
      out.position = vectorAt(rays.origins, i) + out.t * vectorAt(rays.directions, i);
      out.normal = space.normal(hit.normal);
    }
  });
  errors.check(*scene);
  return result;
}

std::vector<char> Terrain::occluded(const RayArrays<double>& rays, unsigned threads) const {
  const Box3f box = scene->bounds();
  std::vector<char> result(size_t(rays.tnear.size()));
  parallelFor(result.size(), chunk, threads, [&](size_t begin, size_t end) {
    std::vector<Ray> batch(end - begin);
    for (size_t i = begin; i < end; i++) batch[i - begin] = rayOf(space, rays, i, box).ray;
    traceAny(*scene, batch.size(), batch.data(), &result[begin]);
  });
  errors.check(*scene);
  return result;
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
