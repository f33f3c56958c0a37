// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays from NumPy arrays and hits as such. Both have a shape, that of the arrays without their last axis of x, y and
 * z: pictures stay pictures. */

#include "arrays.h"

#include "building/surface_hit.h"
#include "tracing/ray.h"

namespace cbvh::python {

struct Rays
{
  Shape shape;
  std::vector<Ray> rays; // in NumPy's order, the last index fastest
};

/* Arguments as of Scene.intersect, which NumPy's rules broadcast to one shape. */
Rays readRays(const py::object& origins, const py::object& directions, const py::object& tnear, const py::object& tfar,
              const py::object& time);
Rays readRays(const py::object& origins, const py::object& directions);

struct Hits
{
  Shape shape;
  std::vector<SurfaceHit> hits;
  size_t facesOfCopy = 0, faces = 0; // of the model
};

/* Refuses hits of another number of rays than those of other arguments. */
void requireRays(const Hits& hits, const std::string& argument, size_t rays, const std::string& others);

void defineHits(py::module_& module);

} // namespace cbvh::python
