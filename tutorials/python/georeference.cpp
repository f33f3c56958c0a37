// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "georeference.h"

#include <algorithm>
#include <cmath>

namespace programs::python {

std::pair<double, double> readCell(const py::object& value) {
  const Doubles cell(realNumbers(value, "cell"));
  if (cell.ndim() > 1 || cell.size() < 1 || cell.size() > 2)
    throwValueError("cell", "has shape " + shapeText(shapeOf(cell)) + ": expected one or two numbers");
  const double x = cell.data()[0], y = cell.size() == 2 ? cell.data()[1] : -x;
  if (!std::isfinite(x) || !std::isfinite(y) || x == 0 || y == 0 || (cell.size() == 1 && x < 0))
    throwValueError("cell", "is " + std::string(py::str(value)) +
                                ": expected a number above 0, or two finite numbers other than 0");
  return {x, y};
}

Georeference::Georeference(size_t rows, size_t columns, double cellX, double cellY, Vec3d origin, double maxError)
  : rows(rows),
    columns(columns),
    cellX(cellX),
    cellY(cellY),
    origin(origin),
    maxError(maxError),
    middleRow(double(rows / 2)),
    middleColumn(double(columns / 2)) {
  const double cell = std::sqrt(std::abs(cellX) * std::abs(cellY));
  int exponent = int(std::lround(std::log2(cell)));
  if (maxError > 0) {
    heightSpacing = float(std::ldexp(1.0, std::ilogb(maxError)));
    exponent = std::max(exponent, std::ilogb(maxError));
  }
  step = std::ldexp(1.0, exponent);
}

Vec3f Georeference::vertex(size_t row, size_t column, double height) const {
  const double spacing = double(heightSpacing);
  const double z = spacing > 0 ? std::nearbyint(height / spacing) * spacing : height;
  return {float((double(column) - middleColumn) * step), float((double(row) - middleRow) * step), float(z)};
}

std::pair<double, double> Georeference::place(Vec3d position) const {
  return {(position.y - origin.y) / cellY, (position.x - origin.x) / cellX};
}

Vec3d Georeference::position(double row, double column, double height) const {
  return {origin.x + column * cellX, origin.y + row * cellY, origin.z + height};
}

Vec3f Georeference::normal(Vec3f n) const {
  const Vec3d mapped = normalize(Vec3d{double(n.x) * step / cellX, double(n.y) * step / cellY, double(n.z)});
  const double sign = mapped.z < 0 ? -1 : 1;
  return {float(sign * mapped.x), float(sign * mapped.y), float(sign * mapped.z)};
}

Georeference::SceneRay Georeference::ray(Vec3d from, Vec3d along, double tnear, double tfar, const Box3f& box) const {
  const auto [row, column] = place(from);
  const Vec3d o{(column - middleColumn) * step, (row - middleRow) * step, from.z - origin.z};
  const Vec3d d{along.x / cellX * step, along.y / cellY * step, along.z};
  SceneRay result;
  result.scale = 1 / length(d);

  /* The box with a margin, so that rounding the origin does not move it past the surface. */
  const Vec3d corner = toDouble(maximum(box.upper, -box.lower)); // the largest coordinates, as heights may be large
  const double margin = step + double(heightSpacing) + 1e-6 * std::max({corner.x, corner.y, corner.z, 0.0});
  double begin = std::max(tnear, 0.0), end = tfar;
  const auto clip = [&](double at, double slope, double lower, double upper) {
    if (slope == 0) {
      if (at < lower - margin || at > upper + margin) end = -1;
      return;
    }
    const double a = (lower - margin - at) / slope, b = (upper + margin - at) / slope;
    begin = std::max(begin, std::min(a, b));
    end = std::min(end, std::max(a, b));
  };
  clip(o.x, d.x, double(box.lower.x), double(box.upper.x));
  clip(o.y, d.y, double(box.lower.y), double(box.upper.y));
  clip(o.z, d.z, double(box.lower.z), double(box.upper.z));
  if (!(begin <= end)) {
    result.ray.tfar = -1;
    return result;
  }
  const Vec3d start = o + begin * d;
  const Vec3d unit = result.scale * d;
  result.ray.origin = {float(start.x), float(start.y), float(start.z)};
  /* Distances count from the exact start, not from the rounded one. */
  result.start = begin + result.scale * dot(toDouble(result.ray.origin) - start, unit);
  result.ray.direction = {float(unit.x), float(unit.y), float(unit.z)};
  result.ray.tfar = float((end - begin) / result.scale);
  return result;
}

} // namespace programs::python
