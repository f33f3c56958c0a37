// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Hits of rays as NumPy arrays. */

#include "arrays.h"
#include "large_array.h"

#include "building/face_numbers.h"
#include "building/surface_hit.h"

#include <memory>
#include <vector>

namespace programs::python {

struct Hits {
  Shape shape;
  LargeArray<SurfaceHit> hits;              // in C order
  std::shared_ptr<const FaceNumbers> faces; // of the scene

  std::vector<SurfaceHit> vector() const { return {hits.begin(), hits.end()}; }
};

/* Raises ValueError unless there are `rays` hits, as many as rays in the arguments `others`. */
void requireRays(const Hits& hits, const std::string& argument, size_t rays, const std::string& others);

void defineHits(py::module_& module);

} // namespace programs::python
