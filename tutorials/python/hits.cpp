// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "hits.h"

#include "measure/hit_metrics.h"

#include <algorithm>
#include <memory>
#include <type_traits>

namespace programs::python {
namespace {

py::tuple tupleOf(const Shape& shape) { return py::tuple(py::cast(shape)); }

template<typename T>
py::array member(const py::object& self, T SurfaceHit::* member) {
  const Hits& hits = self.cast<const Hits&>();
  Shape strides(hits.shape.size());
  py::ssize_t stride = sizeof(SurfaceHit);
  for (size_t i = strides.size(); i-- > 0; stride *= hits.shape[i]) strides[i] = stride;
  static const SurfaceHit none;
  const SurfaceHit* const first = hits.hits.size() ? hits.hits.data() : &none;
  if constexpr (std::is_same_v<T, Vec3f>) {
    Shape shape = hits.shape;
    shape.push_back(3);
    strides.push_back(sizeof(float));
    return view(&(first->*member).x, shape, strides, self);
  } else return view(&(first->*member), hits.shape, strides, self);
}

/* Embree's invalid ID for misses. */
template<typename Function>
py::array_t<unsigned> ids(const Hits& hits, const Function& idOfFace) {
  return arrayOf<unsigned>(hits.shape, [&](size_t i) {
    return hits.hits[i].hit() ? unsigned(idOfFace(hits.hits[i].face)) : RTC_INVALID_GEOMETRY_ID;
  });
}

std::string repr(const Hits& hits) {
  size_t count = 0;
  for (const SurfaceHit& hit : hits.hits) count += hit.hit();
  return "<Hits of shape " + shapeText(hits.shape) + ", " + std::to_string(count) + " of " +
         std::to_string(hits.hits.size()) + " rays hit>";
}

std::shared_ptr<Hits> nearer(const Hits& a, const Hits& b) {
  requireRays(b, "b", a.hits.size(), "a");
  const std::vector<SurfaceHit> hits = nearerHits(a.vector(), b.vector());
  auto result = std::make_shared<Hits>(Hits{a.shape, LargeArray<SurfaceHit>(hits.size()), a.faces});
  std::copy(hits.begin(), hits.end(), result->hits.begin());
  return result;
}

} // namespace

void requireRays(const Hits& hits, const std::string& argument, size_t rays, const std::string& others) {
  if (hits.hits.size() != rays)
    throwValueError(argument, "has " + std::to_string(hits.hits.size()) + " rays: expected " + std::to_string(rays) +
                                  ", as " + others);
}

void defineHits(py::module_& module) {
  py::class_<Hits, std::shared_ptr<Hits>>(module, "Hits",
                                          R"(Hits of rays, in arrays of the shape of the rays, (...) below.

t, u, v and Ng are read-only views of the hits. hit, primID and geomID are new arrays at each access.

Hits on NAIVE's triangles are converted to the surface: primID, u and v have the same meaning in all representations, so
hits can be compared.)")
      .def_property_readonly(
          "hit", [](const Hits& h) { return arrayOf<bool>(h.shape, [&](size_t i) { return h.hits[i].hit(); }); },
          "(...) bool: True if the ray hits anything.")
      .def_property_readonly(
          "t", [](const py::object& self) { return member(self, &SurfaceHit::t); },
          "(...) float32: distance in lengths of the ray's direction; inf for a miss.")
      .def_property_readonly(
          "u", [](const py::object& self) { return member(self, &SurfaceHit::u); },
          R"((...) float32: parameter of the face, from 0 to 1; 0 for a miss.

A Grid has u along its columns and v along its rows: they are 0 at sample [0, 0], and 1 at the last ones. On a triangle,
u and v are the weights of its second and third vertex. A quad 0, 1, 2, 3 is (u, v) = (0, 0), (1, 0), (1, 1), (0, 1).

A face of n != 4 vertices is n patches, one per corner: at corner i, u is from 0.5 to 1.5 plus 2*(i % 4), and v from 0.5
to 1.5 plus 2*(i // 4), as Embree reports them.)")
      .def_property_readonly(
          "v", [](const py::object& self) { return member(self, &SurfaceHit::v); },
          "(...) float32: the other parameter, see u.")
      .def_property_readonly(
          "Ng", [](const py::object& self) { return member(self, &SurfaceHit::normal); },
          "(..., 3) float32: geometric normal, dP/du x dP/dv, not normalized; 0 for a miss.")
      .def_property_readonly(
          "primID", [](const Hits& h) { return ids(h, [&](unsigned f) { return h.faces->primID(f); }); },
          "(...) uint32: face of a cage or mesh, from 0; 0 for a Grid; 2**32 - 1 for a miss.")
      .def_property_readonly(
          "geomID", [](const Hits& h) { return ids(h, [&](unsigned f) { return h.faces->geomID(f); }); },
          R"((...) uint32: index of the geometry in the scene; 2**32 - 1 for a miss.

In a ModelScene it is the copy of the cage, 0 unless the model has several.)")
      .def_property_readonly(
          "shape", [](const Hits& h) { return tupleOf(h.shape); }, "Shape of the rays.")
      .def("__repr__", repr);

  module.def("nearer_hits", nearer, py::arg("a"), py::arg("b"), R"(Returns the nearer hit of each ray, as Hits.

If two scenes of one surface differ because a ray slipped between two triangles, as sometimes in NAIVE, the nearer hit
is the correct one: nearer_hits(grid, naive) is the reference of errors in cbvh_render.)");
}

} // namespace programs::python
