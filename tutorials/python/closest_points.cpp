// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "closest_points.h"
#include "hits.h"
#include "interruptible.h"

#include "basics/parallel.h"

#include <embree3/rtcore_surface.h>

#include <cmath>
#include <memory>

namespace programs::python {
namespace {

struct Found {
  std::vector<SurfaceHit> hits;
  std::vector<Vec3f> positions;
};

/* Point i is the origin of ray i, its radius tfar. */
Found find(const Scene& scene, const std::vector<Ray>& rays, unsigned threads) {
  constexpr size_t chunk = 1024;
  Found found = {std::vector<SurfaceHit>(rays.size()), std::vector<Vec3f>(rays.size(), Vec3f{NAN, NAN, NAN})};
  parallelFor(rays.size(), chunk, threads, [&](size_t begin, size_t end) {
    for (size_t i = begin; i < end; i++) {
      CbvhPointQuery query = CbvhPointQuery();
      query.x = rays[i].origin.x;
      query.y = rays[i].origin.y;
      query.z = rays[i].origin.z;
      query.time = rays[i].time;
      query.radius = rays[i].tfar;
      CbvhClosestPoint closest;
      if (!rtcFindClosestPoint(scene.traced().handle(), &query, &closest)) continue;
      RTCRayHit hit = RTCRayHit();
      hit.ray.tfar = closest.distance;
      hit.hit.Ng_x = closest.Ng_x;
      hit.hit.Ng_y = closest.Ng_y;
      hit.hit.Ng_z = closest.Ng_z;
      hit.hit.u = closest.u;
      hit.hit.v = closest.v;
      hit.hit.primID = closest.primID;
      hit.hit.geomID = closest.geomID;
      found.hits[i] = scene.traced().surfaceHit(hit);
      found.positions[i] = {closest.x, closest.y, closest.z};
    }
  });
  scene.checkRays();
  return found;
}

} // namespace

py::tuple closestPoints(const Scene& scene, const py::object& points, const py::object& radius, const py::object& time,
                        unsigned threads) {
  scene.requireSearchable("finding closest points");
  const Shape given = shapeOf(floats(points, "points"));
  if (given.empty() || given.back() != 3)
    throwValueError("points", "has shape " + shapeText(given) + ": expected (..., 3)");
  floats(radius, "radius"); // rejects what is no number by its name
  const py::tuple noDirection = py::make_tuple(0.0f, 0.0f, 0.0f);
  Rays rays = readRays(points, noDirection, py::float_(0.0), radius, time);
  for (const Ray& ray : rays.rays)
    for (const float coordinate : {ray.origin.x, ray.origin.y, ray.origin.z})
      if (!(std::fabs(coordinate) <= 1e18f)) // as the library
        throwValueError("points", "has the coordinate " + std::to_string(coordinate) + ": expected -1e18 to 1e18");
  for (const Ray& ray : rays.rays)
    if (!(ray.tfar >= 0.0f)) throwValueError("radius", "is " + std::to_string(ray.tfar) + ": expected at least 0");
  Found found = interruptibleQuery([&] { return find(scene, rays.rays, threads); });
  Shape shape = rays.shape;
  shape.push_back(3);
  const py::array_t<float> positions =
      arrayOf<float>(shape, [&](size_t i) { return (&found.positions[i / 3].x)[i % 3]; });
  auto hits = std::make_shared<Hits>(Hits{std::move(rays.shape), std::move(found.hits), scene.faces()});
  return py::make_tuple(positions, hits);
}

} // namespace programs::python
