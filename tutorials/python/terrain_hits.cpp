// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "terrain_hits.h"

#include <memory>

namespace programs::python {
namespace {

/* One value per hit. */
template<typename T, typename Function>
py::array_t<T> values(const TerrainHits& hits, const Function& function) {
  return arrayOf<T>(hits.shape, [&](size_t i) { return function(hits.hits[i]); });
}

/* Three values per hit. */
template<typename T, typename Function>
py::array_t<T> vectors(const TerrainHits& hits, const Function& function) {
  Shape shape = hits.shape;
  shape.push_back(3);
  return arrayOf<T>(shape, [&](size_t i) { return (&function(hits.hits[i / 3]).x)[i % 3]; });
}

} // namespace

void defineTerrainHits(py::module_& module) {
  py::class_<TerrainHits, std::shared_ptr<TerrainHits>>(
      module, "TerrainHits",
      "Hits on a Terrain, in arrays of the shape of the rays, (...) below. They are new arrays at each access.")
      .def_property_readonly(
          "hit",
          [](const TerrainHits& h) { return values<bool>(h, [](const TerrainHit& x) { return x.t < INFINITY; }); },
          "(...) bool: True if the ray hits the terrain.")
      .def_property_readonly(
          "t", [](const TerrainHits& h) { return values<double>(h, [](const TerrainHit& x) { return x.t; }); },
          "(...) float64: distance in lengths of the ray's direction; inf for a miss.")
      .def_property_readonly(
          "position",
          [](const TerrainHits& h) {
            return vectors<double>(h, [](const TerrainHit& x) -> const Vec3d& { return x.position; });
          },
          "(..., 3) float64: origins + t * directions, in the raster's coordinates; NaN for a miss.")
      .def_property_readonly(
          "normal",
          [](const TerrainHits& h) {
            return vectors<float>(h, [](const TerrainHit& x) -> const Vec3f& { return x.normal; });
          },
          "(..., 3) float32: upward normal of the triangle, of length 1; 0 for a miss.")
      .def_property_readonly(
          "row",
          [](const TerrainHits& h) {
            return values<double>(h, [&](const TerrainHit& x) { return h.space.place(x.position).first; });
          },
          "(...) float64: place of the hit in the raster, 0 at the first row; NaN for a miss.")
      .def_property_readonly(
          "column",
          [](const TerrainHits& h) {
            return values<double>(h, [&](const TerrainHit& x) { return h.space.place(x.position).second; });
          },
          "(...) float64: place of the hit in the raster, 0 at the first column; NaN for a miss.")
      .def_property_readonly(
          "shape", [](const TerrainHits& h) { return py::tuple(py::cast(h.shape)); }, "Shape of the rays.")
      .def("__repr__", [](const TerrainHits& h) {
        size_t count = 0;
        for (const TerrainHit& hit : h.hits) count += hit.t < INFINITY;
        return "<TerrainHits of shape " + shapeText(h.shape) + ", " + std::to_string(count) + " of " +
               std::to_string(h.hits.size()) + " rays hit>";
      });
}

} // namespace programs::python
