// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts NumPy arrays to rays, and hits to NumPy arrays. Shapes exclude the last axis, x, y and z. */

#include "arrays.h"

#include "building/surface_hit.h"
#include "tracing/ray.h"

namespace programs::python {

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
  size_t facesPerCopy = 0, faces = 0; // of the model
};

/* Raises ValueError unless the time is from 0 to 1. */
void requireTime(float time);

/* Raises ValueError unless there are `rays` hits, as many as rays in the arguments `others`. */
void requireRays(const Hits& hits, const std::string& argument, size_t rays, const std::string& others);

void defineHits(py::module_& module);

} // namespace programs::python
