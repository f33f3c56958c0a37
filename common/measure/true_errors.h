// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Distances of hits from the true surface: the errors of tessellation and compression together. */

#include "building/surface_hit.h"
#include "measure/error_summary.h"
#include "surface/true_surface.h"
#include "tracing/ray.h"

#include <cstdint>
#include <vector>

namespace programs {

struct TrueErrors : ErrorSummary {
  size_t hits = 0;
  /* In world units. */
  double rmseWorld = 0, medianWorld = 0, p99World = 0;
  /* Signed distance along the ray in pixels, positive behind the true surface. Excludes rays that do not intersect
   * it within 5 pixels. */
  double rmseAlong = 0, bias = 0;
  size_t outliers = 0; // hits of the excluded rays
};

/* Indices of `count` random hits, or of all if there are fewer, in ascending order. */
std::vector<size_t> sampleHits(const std::vector<SurfaceHit>& hits, size_t count, uint32_t seed);

struct TrueView {
  const Model& model;
  const TrueSurfaces& surfaces;
  const std::vector<Ray>& rays;
  std::vector<size_t> sample; // indices of rays to measure
  float footprint;            // width of a pixel at distance 1
};

/* `hits` holds one entry per ray of the view; misses are ignored. `layout` is the model's at the level of the hits.
 * Throws Canceled. */
TrueErrors compareToTrueSurface(const TrueView& view, const std::vector<SurfaceHit>& hits, const PatchLayout& layout,
                                unsigned threads);

} // namespace programs
