// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts NumPy arrays to rays, and hits to NumPy arrays. Shapes exclude the last axis, x, y and z. */

#include "arrays.h"

#include "building/face_numbers.h"
#include "building/surface_hit.h"
#include "tracing/ray.h"

#include <memory>

namespace programs::python {

/* Arguments as for Scene.intersect, broadcast by NumPy's rules. */
template<typename T>
struct RayArrays {
  using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;

  Shape shape;
  Array origins, directions, tnear, tfar, time;
};

template<typename T>
RayArrays<T> readRayArrays(const py::object& origins, const py::object& directions, const py::object& tnear,
                           const py::object& tfar, const py::object& time);

struct Rays {
  Shape shape;
  std::vector<Ray> rays; // in C order
};

/* Arguments as for Scene.intersect, broadcast by NumPy's rules. */
Rays readRays(const py::object& origins, const py::object& directions, const py::object& tnear, const py::object& tfar,
              const py::object& time);
Rays readRays(const py::object& origins, const py::object& directions);

struct Hits {
  Shape shape;
  std::vector<SurfaceHit> hits;
  std::shared_ptr<const FaceNumbers> faces; // of the scene
};

/* Raises ValueError unless the time is from 0 to 1. */
void requireTime(float time);

/* Raises ValueError unless there are `rays` hits, as many as rays in the arguments `others`. */
void requireRays(const Hits& hits, const std::string& argument, size_t rays, const std::string& others);

void defineHits(py::module_& module);

} // namespace programs::python
