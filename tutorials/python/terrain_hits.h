// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Hits of rays on a terrain, in the coordinates of its raster. */

#include "georeference.h"

#include <limits>
#include <vector>

namespace programs::python {

struct TerrainHit {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();

  double t = INFINITY; // infinity for a miss
  Vec3d position{none, none, none};
  Vec3f normal;
};

struct TerrainHits {
  TerrainHits(Shape shape, const Georeference& space) : shape(std::move(shape)), space(space) {}

  Shape shape;
  Georeference space;
  std::vector<TerrainHit> hits;
};

void defineTerrainHits(py::module_& module);

} // namespace programs::python
