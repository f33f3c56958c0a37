// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "camera.h"
#include "classes.h"
#include "hits.h"
#include "ray_arrays.h"

#include "tracing/ray_sets.h"

#include <cmath>
#include <cstdio>

namespace programs::python {

ImageSize imageSize(std::pair<int, int> size) {
  constexpr int most = 16384; // as for --size of the programs
  if (size.first < 1 || size.second < 1 || size.first > most || size.second > most)
    throwValueError("size", "is (" + std::to_string(size.first) + ", " + std::to_string(size.second) +
                                "): expected width and height from 1 to " + std::to_string(most));
  return {size.first, size.second};
}

namespace {

Camera makeCamera(const py::object& eye, const py::object& lookAt, const py::object& up, float fov,
                  std::pair<int, int> size) {
  const Vec3f from = vec3(eye, "eye"), to = vec3(lookAt, "look_at"), upwards = vec3(up, "up");
  const double distance = length(toDouble(to) - toDouble(from));
  if (!(distance >= 1e-18 && distance <= 1e18)) // its square is a normal float
  {
    char text[64];
    std::snprintf(text, sizeof(text), "is %g away from eye: expected 1e-18 to 1e18", distance);
    throwValueError("look_at", text);
  }
  if (upwards.x == 0.0f && upwards.y == 0.0f && upwards.z == 0.0f)
    throwValueError("up", "has length 0: expected a direction");
  if (!(fov > 0.0f && fov < 180.0f))
    throwValueError("fov", "is " + std::to_string(fov) + ": expected more than 0 and less than 180 degrees");
  return Camera(from, to, upwards, fov, imageSize(size));
}

/* (origins, directions), as for Scene.intersect. */
py::tuple arraysOf(const std::vector<Ray>& rays, Shape shape) {
  shape.push_back(3);
  const auto origin = [&](size_t i) { return (&rays[i / 3].origin.x)[i % 3]; };
  const auto direction = [&](size_t i) { return (&rays[i / 3].direction.x)[i % 3]; };
  return py::make_tuple(arrayOf<float>(shape, origin), arrayOf<float>(shape, direction));
}

py::tuple arraysOf(const std::vector<Ray>& rays) { return arraysOf(rays, {py::ssize_t(rays.size())}); }

py::tuple bounce(const Hits& hits, const py::object& origins, const py::object& directions, float offset, size_t count,
                 uint32_t seed) {
  if (!(offset >= 0.0f) || !std::isfinite(offset))
    throwValueError("offset", "is " + std::to_string(offset) + ": expected a finite number of at least 0");
  const std::vector<Ray> rays = readRays(origins, directions).rays();
  requireRays(hits, "hits", rays.size(), "origins and directions");
  return arraysOf(bounceRays(rays, hits.vector(), {count, offset, seed}));
}

} // namespace

void defineCamera(py::module_& module) {
  py::class_<Camera>(module, "Camera", "A pinhole camera with square pixels.")
      .def(py::init(&makeCamera), py::arg("eye"), py::arg("look_at"), py::arg("up") = py::make_tuple(0.0, 1.0, 0.0),
           py::arg("fov") = 35.0f, py::arg("size") = std::pair<int, int>(1024, 1024),
           R"(Creates a camera.

eye, look_at: (3,) each, world units.
up: (3,), the up direction of the picture.
fov: vertical field of view, degrees.
size: width and height of the picture in pixels, 1 to 16384 each.)")
      .def_property_readonly(
          "eye", [](const Camera& c) { return arrayOf(c.eye()); }, "(3,) float32, world units.")
      .def_property_readonly(
          "look_at", [](const Camera& c) { return arrayOf(c.lookAt()); }, "(3,) float32, world units.")
      .def_property_readonly("fov", &Camera::fov, "Vertical field of view, degrees.")
      .def_property_readonly(
          "size", [](const Camera& c) { return py::make_tuple(c.size().width, c.size().height); },
          "Width and height of the picture in pixels.")
      .def_property_readonly(
          "pixel_size", &Camera::footprint,
          "Width of a pixel at a distance of 1, the unit of errors. At distance t it is t times this.")
      .def("__repr__", [](const Camera& c) { return "<Camera " + c.description() + ">"; });

  module.def(
      "primary_rays", [](const Camera& c) { return arraysOf(primaryRays(c), {c.size().height, c.size().width}); },
      py::arg("camera"),
      R"(Returns one ray through the center of each pixel: origins and directions, (height, width, 3) float32 each.

Row 0 is the upper row. Directions have unit length, so distances of hits are in world units.)");
  module.def(
      "coherent_rays",
      [](const Camera& c, size_t count) { return arraysOf(coherentRays(primaryRays(c), c.size(), count)); },
      py::arg("camera"), py::arg("count") = 0,
      R"(Returns primary rays in the order in which renderers trace them, tiles of 8 x 8 pixels.

count: approximate number of rays, as whole tiles that are spread evenly over the picture; 0 for all.

Returns origins and directions, (n, 3) float32 each.)");
  module.def("bounce_rays", &bounce, py::arg("hits"), py::arg("origins"), py::arg("directions"), py::kw_only(),
             py::arg("offset"), py::arg("count") = 0, py::arg("seed") = 1,
             R"(Returns incoherent rays: one per hit, with a cosine distribution about the geometric normal, shuffled.

hits: hits of the rays origins and directions, which are as in Scene.intersect.
offset: distance of the origins from the surface along the normal, world units. cbvh_render uses 1e-4 of the scene's
  diagonal.
count: largest number of rays, 0 for one per hit.
seed: the same seed returns the same rays.

Returns origins and directions, (n, 3) float32 each. Rays start on the visible side of the surface.)");
}

} // namespace programs::python
