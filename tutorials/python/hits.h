// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts NumPy arrays to rays, and hits to NumPy arrays. Both keep the shape of the arrays without their last axis of
 * x, y and z, so pictures stay pictures. */

#include "arrays.h"

#include "building/surface_hit.h"
#include "tracing/ray.h"

namespace cbvh::python {

struct Rays
{
  Shape shape;
  std::vector<Ray> rays; // in C order, the last index fastest
};

/* Reads arguments as in Scene.intersect, broadcast to one shape by NumPy's rules. */
Rays readRays(const py::object& origins, const py::object& directions, const py::object& tnear, const py::object& tfar,
              const py::object& time);
Rays readRays(const py::object& origins, const py::object& directions);

struct Hits
{
  Shape shape;
  std::vector<SurfaceHit> hits;
  size_t facesOfCopy = 0, faces = 0; // of the model
};

/* Raises ValueError unless there are `rays` hits, the number of rays in the arguments `others`. */
void requireRays(const Hits& hits, const std::string& argument, size_t rays, const std::string& others);

void defineHits(py::module_& module);

} // namespace cbvh::python
