// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "point_queries.h"
#include "hits.h"
#include "inside.h"
#include "interruptible.h"
#include "ray_arrays.h"

#include "basics/parallel.h"
#include "tracing/denormals.h"

#include <embree3/rtcore_surface.h>

#include <cmath>
#include <memory>

namespace programs::python {
namespace {

constexpr size_t chunk = 1024;             // points per task
constexpr float largestCoordinate = 1e18f; // of the library's point queries

/* Point i is the origin of ray i, its radius tfar. Returns false if no point is within the radius. */
bool find(const TracedScene& scene, const RayArrays& points, size_t i, CbvhClosestPoint& closest) {
  const Ray point = points.ray(i);
  CbvhPointQuery query = CbvhPointQuery();
  query.x = point.origin.x;
  query.y = point.origin.y;
  query.z = point.origin.z;
  query.time = point.time;
  query.radius = point.tfar;
  return rtcFindClosestPoint(scene.handle(), &query, &closest);
}

SurfaceHit hitOf(const TracedScene& scene, const CbvhClosestPoint& closest) {
  RTCRayHit hit = RTCRayHit();
  hit.ray.tfar = closest.distance;
  hit.hit.Ng_x = closest.Ng_x;
  hit.hit.Ng_y = closest.Ng_y;
  hit.hit.Ng_z = closest.Ng_z;
  hit.hit.u = closest.u;
  hit.hit.v = closest.v;
  hit.hit.primID = closest.primID;
  hit.hit.geomID = closest.geomID;
  return scene.surfaceHit(hit);
}

void requirePoints(const RayArrays& points) {
  for (size_t i = 0; i < points.count; i++) {
    const Ray point = points.ray(i);
    for (const float coordinate : {point.origin.x, point.origin.y, point.origin.z})
      if (!(std::fabs(coordinate) <= largestCoordinate))
        throwValueError("points", "has the coordinate " + std::to_string(coordinate) + ": expected -1e18 to 1e18");
    if (!(point.tfar >= 0.0f)) throwValueError("radius", "is " + std::to_string(point.tfar) + ": expected at least 0");
  }
}

/* `points` as origins of rays. */
RayArrays readPoints(const py::object& points, const py::object& radius, const py::object& time) {
  shapeOfVectors(realNumbers(points, "points"), "points");
  realNumbers(radius, "radius"); // rejects what is no number by its name
  const RayArrays result = readRays(points, py::make_tuple(0.0f, 0.0f, 0.0f), py::float_(0.0), radius, time);
  requirePoints(result);
  return result;
}

/* Calls query(i) for all points, on several threads and without Python's lock. */
template<typename Query>
void forEachPoint(const Scene& scene, const RayArrays& points, int threads, const Query& query) {
  runQuery(points.count, chunk, threadsOf(threads), [&](unsigned n) {
    parallelFor(points.count, chunk, n, [&](size_t begin, size_t end) {
      for (size_t i = begin; i < end; i++) query(i);
    });
    scene.checkRays();
  });
}

bool isPointInside(const Scene& scene, const RayArrays& points, size_t i) {
  const FlushDenormals denormals;
  const Ray point = points.ray(i);
  return isInside(scene.traced().handle(), point.origin, point.time);
}

/* Infinity if no point is within the radius. */
float distance(const Scene& scene, const RayArrays& points, size_t i) {
  CbvhClosestPoint closest;
  return find(scene.traced(), points, i, closest) ? closest.distance : INFINITY;
}

/* --- methods --------------------------------------------------------------------------- */

py::tuple closestPoints(const Scene& scene, const py::object& points, const py::object& radius, const py::object& time,
                        int threads) {
  scene.requireSearchable("finding closest points");
  const RayArrays from = readPoints(points, radius, time);
  Shape vectors = from.shape;
  vectors.push_back(3);
  py::array_t<float> positions(vectors);
  Vec3f* const position = reinterpret_cast<Vec3f*>(positions.mutable_data());
  auto hits = std::make_shared<Hits>(Hits{from.shape, LargeArray<SurfaceHit>(from.count), scene.faces()});
  forEachPoint(scene, from, threads, [&](size_t i) {
    CbvhClosestPoint closest;
    const bool isFound = find(scene.traced(), from, i, closest);
    hits->hits[i] = isFound ? hitOf(scene.traced(), closest) : SurfaceHit();
    position[i] = isFound ? Vec3f{closest.x, closest.y, closest.z} : Vec3f{NAN, NAN, NAN};
  });
  return py::make_tuple(positions, hits);
}

py::array_t<float> distances(const Scene& scene, const py::object& points, const py::object& radius,
                             const py::object& time, int threads) {
  scene.requireSearchable("measuring distances");
  const RayArrays from = readPoints(points, radius, time);
  py::array_t<float> result(from.shape);
  float* const out = result.mutable_data();
  forEachPoint(scene, from, threads, [&](size_t i) { out[i] = distance(scene, from, i); });
  return result;
}

py::array_t<float> signedDistances(const Scene& scene, const py::object& points, const py::object& radius,
                                   const py::object& time, int threads) {
  scene.requireSearchable("measuring distances");
  const RayArrays from = readPoints(points, radius, time);
  py::array_t<float> result(from.shape);
  float* const out = result.mutable_data();
  forEachPoint(scene, from, threads, [&](size_t i) {
    const float size = distance(scene, from, i);
    out[i] = isPointInside(scene, from, i) ? size : -size;
  });
  return result;
}

py::array_t<bool> contains(const Scene& scene, const py::object& points, const py::object& time, int threads) {
  scene.requireSearchable("testing points");
  const RayArrays from = readPoints(points, py::float_(0.0), time);
  py::array_t<bool> result(from.shape);
  bool* const out = result.mutable_data();
  forEachPoint(scene, from, threads, [&](size_t i) { out[i] = isPointInside(scene, from, i); });
  return result;
}

/* --- docstrings ------------------------------------------------------------------------ */

constexpr const char* closestText = R"(Finds the closest point of the surface for each point.

points: (..., 3), world units.
radius: (...), largest distance, may be inf.
time: (...), 0 to 1, for geometries that move.
threads: 0 for all.

Returns two results: positions, (..., 3) float32, the closest points in world units, NaN where none is within the
radius; and Hits, in which t is the distance, inf where there is none. Arguments are broadcast by NumPy's rules. Only
for ctile and cvert, whose stored triangles are searched. Ctrl-C stops the call.

Raises ValueError or TypeError for invalid arguments, and Error for other representations, or if a block of a loaded
file is damaged.)";

constexpr const char* distanceText = R"(Returns the distance of each point from the surface, (...) float32, world units.

Arguments and errors as in closest_points. The distance is inf where no point of the surface is within the radius.)";

constexpr const char* signedText = R"(Returns signed distances from a closed surface, (...) float32, world units.

The distance is positive inside, negative outside, and infinite where no point of the surface is within the radius.
Arguments and errors as in closest_points. Inside is defined as in contains.)";

constexpr const char* containsText = R"(Returns (...) bool: True if the surface encloses the point.

points: (..., 3), world units.
time: (...), 0 to 1, for geometries that move.
threads: 0 for all.

A point is inside if rays from it cross the surface an odd number of times, whatever the orientation of the triangles:
a point in two overlapping bodies is outside. Two rays must agree, otherwise a third one decides. Surfaces must be
closed: near a hole, or in front of an open surface, the result depends on the directions of the rays, without an error.
Points on the surface, up to rounding to 32 bits, may be on either side. Errors as in closest_points.)";

} // namespace

void definePointQueries(py::class_<Scene, std::shared_ptr<Scene>>& scene) {
  using py::arg;
  const py::float_ zero(0.0), infinity(INFINITY);
  scene
      .def("closest_points", &closestPoints, arg("points"), arg("radius") = infinity, py::kw_only(), arg("time") = zero,
           arg("threads") = 0, closestText)
      .def("distance", &distances, arg("points"), arg("radius") = infinity, py::kw_only(), arg("time") = zero,
           arg("threads") = 0, distanceText)
      .def("signed_distance", &signedDistances, arg("points"), arg("radius") = infinity, py::kw_only(),
           arg("time") = zero, arg("threads") = 0, signedText)
      .def("contains", &contains, arg("points"), py::kw_only(), arg("time") = zero, arg("threads") = 0, containsText);
}

} // namespace programs::python
