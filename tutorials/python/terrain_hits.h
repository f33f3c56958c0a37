// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Hits of rays on a terrain, in the coordinates of its raster. */

#include "georeference.h"
#include "large_array.h"

#include <limits>

namespace programs::python {

struct TerrainHit {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  double t = INFINITY; // infinity for a miss
  Vec3d position{none, none, none};
  Vec3f normal;
};

struct TerrainHits {
  TerrainHits(Shape shape, const Georeference& space, size_t count)
    : shape(std::move(shape)),
      space(space),
      hits(count) {}

  Shape shape;
  Georeference space;
  LargeArray<TerrainHit> hits; // in C order
};

void defineTerrainHits(py::module_& module);

} // namespace programs::python
