// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Horizons, sky-view factors and viewsheds. */

#include "interruptible.h"
#include "scene.h"
#include "terrain.h"

#include <algorithm>
#include <cmath>

namespace programs::python {
namespace {

/* Requires shape (..., 3), finite. Writes the shape without the last axis. */
std::vector<Vec3d> readPoints(const py::object& value, const std::string& argument, Shape& shape) {
  const Doubles array(realNumbers(value, argument));
  shape = shapeOf(array);
  if (shape.empty() || shape.back() != 3)
    throwValueError(argument, "has shape " + shapeText(shape) + ": expected (..., 3)");
  shape.pop_back();
  std::vector<Vec3d> points(size_t(array.size() / 3));
  for (size_t i = 0; i < points.size(); i++) {
    const double* const p = array.data() + 3 * i;
    if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2]))
      throwValueError(argument, "point " + std::to_string(i) + " is not finite: expected finite numbers");
    points[i] = {p[0], p[1], p[2]};
  }
  return points;
}

void requireAccuracy(double accuracy) {
  if (!(accuracy >= 1e-4 && accuracy <= 90))
    throwValueError("accuracy", "is " + std::to_string(accuracy) + ": expected 0.0001 to 90 degrees");
}

py::array_t<float> horizon(const Terrain& terrain, const py::object& points, const py::object& azimuths,
                           double accuracy, int threads) {
  const unsigned n = threadsOf(threads);
  requireAccuracy(accuracy);
  Shape shape;
  const std::vector<Vec3d> from = readPoints(points, "points", shape);
  const Doubles degrees(realNumbers(azimuths, "azimuths"));
  if (degrees.ndim() != 1) throwValueError("azimuths", "has shape " + shapeText(shapeOf(degrees)) + ": expected (n,)");
  const std::vector<double> directions(degrees.data(), degrees.data() + degrees.size());
  for (const double azimuth : directions)
    if (!std::isfinite(azimuth)) throwValueError("azimuths", "is not finite: expected finite numbers");
  const std::vector<float> found = interruptibleQuery([&] { return terrain.horizons(from, directions, accuracy, n); });
  shape.push_back(degrees.size());
  return arrayOf<float>(shape, [&](size_t i) { return found[i]; });
}

py::array_t<float> skyViewFactor(const Terrain& terrain, const py::object& points, int azimuths, double accuracy,
                                 int threads) {
  const unsigned n = threadsOf(threads);
  requireAccuracy(accuracy);
  if (azimuths < 1 || azimuths > 1 << 16)
    throwValueError("azimuths", "is " + std::to_string(azimuths) + ": expected 1 to 65536");
  Shape shape;
  const std::vector<Vec3d> from = readPoints(points, "points", shape);
  /* + 0.5, because rays along an axis would lie in the plane of a tile's border, as in cbvh_terrain. */
  std::vector<double> directions;
  for (int i = 0; i < azimuths; i++) directions.push_back(360 * (i + 0.5) / azimuths);
  const std::vector<float> found = interruptibleQuery([&] { return terrain.horizons(from, directions, accuracy, n); });
  return arrayOf<float>(shape, [&](size_t i) {
    double sum = 0;
    for (size_t j = 0; j < directions.size(); j++) {
      const double cosine = std::cos(std::max(0.0, double(found[i * directions.size() + j])) * M_PI / 180);
      sum += cosine * cosine;
    }
    return float(sum / azimuths);
  });
}

py::array_t<bool> viewshed(const Terrain& terrain, const py::object& observer, const py::object& points, int threads) {
  const unsigned n = threadsOf(threads);
  const Vec3d from = vec3d(observer, "observer");
  Shape shape;
  const std::vector<Vec3d> targets = readPoints(points, "points", shape);
  Shape vectors = shape;
  vectors.push_back(3);
  Doubles directions(vectors), tfar(shape);
  for (size_t i = 0; i < targets.size(); i++) {
    const Vec3d along = targets[i] - from;
    const bool isHere = !(length(along) > 0);
    const Vec3d direction = isHere ? Vec3d{0, 0, 1} : along;
    std::copy_n(&direction.x, 3, directions.mutable_data() + 3 * i);
    tfar.mutable_data()[i] = isHere ? -1 : 1;
  }
  const RayArrays rays =
      readRays(py::make_tuple(from.x, from.y, from.z), directions, py::float_(0.0), tfar, py::float_(0.0));
  py::array_t<bool> result(shape);
  bool* const seen = result.mutable_data();
  runQuery([&] {
    terrain.occluded(rays, n, seen);
    std::transform(seen, seen + targets.size(), seen, [](bool isHidden) { return !isHidden; });
  });
  return result;
}

constexpr const char* horizonText = R"(Returns the elevation of the horizon, (..., n) float32 in degrees, -90 to 90.

points: (..., 3), from which the terrain is seen, in the raster's coordinates. They must be above the stored surface: at
  least max_error / 2 above a sample.
azimuths: (n,), in degrees: 0 is the direction of y, north, and 90 that of x, east.
accuracy: width in degrees of the interval in which the horizon is found by bisection.
threads: 0 for all.

Nothing is seen beyond the raster: without terrain in a direction, the horizon is -90. Ctrl-C stops the call.
write_raster() writes results for samples of the raster as a GeoTIFF.

Raises ValueError or TypeError for invalid arguments, and Error if a block of a loaded file is damaged.)";

constexpr const char* skyText = R"(Returns the share of diffuse light that a horizontal surface gets from the sky.

points, accuracy, threads: as in horizon.
azimuths: number of directions.

Returns (...) float32, 0 to 1: the mean of the squared cosine of the horizon's elevation, or 1 for horizons below 0, as
cbvh_terrain does.)";

constexpr const char* viewshedText = R"(Returns (...) bool: True if a point is seen by an observer.

observer: (3,), in the raster's coordinates.
points: (..., 3), above the stored surface, as in horizon.
threads: 0 for all.)";

} // namespace

void defineHorizons(py::class_<Terrain, std::shared_ptr<Terrain>>& terrain) {
  using py::arg;
  terrain
      .def("horizon", &horizon, arg("points"), arg("azimuths"), py::kw_only(), arg("accuracy") = 0.25,
           arg("threads") = 0, horizonText)
      .def("sky_view_factor", &skyViewFactor, arg("points"), arg("azimuths") = 16, py::kw_only(),
           arg("accuracy") = 0.25, arg("threads") = 0, skyText)
      .def("viewshed", &viewshed, arg("observer"), arg("points"), py::kw_only(), arg("threads") = 0, viewshedText);
}

} // namespace programs::python
