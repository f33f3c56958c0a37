// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Distances of hits from the true surface: the error of tessellation and compression together, measured in the same
 * way for every representation. */

#include "building/surface_hit.h"
#include "measure/error_summary.h"
#include "surface/true_surface.h"
#include "tracing/ray.h"

#include <cstdint>
#include <vector>

namespace cbvh {

/* Errors against the nearest point of the true surface. */
struct TrueErrors : ErrorSummary
{
  size_t hits = 0; // measured hits
  /* Distances in world units. */
  double rmseWorld = 0, medianWorld = 0, p99World = 0;
  /* Signed distance along the ray, in pixels, positive if behind the true surface. Only for hits whose ray intersects
   * the true surface within 5 pixels; other rays graze or miss it. */
  double rmseAlong = 0, bias = 0;
  size_t apart = 0; // number of the other hits
};

/* Returns the indices of `count` random hits in ascending order, or of all hits if there are fewer. */
std::vector<size_t> sampleHits(const std::vector<SurfaceHit>& hits, size_t count, uint32_t seed);

/* Reference of all representations in a view. */
struct TrueView
{
  const Model& model;
  const TrueSurfaces& surfaces; // of the model
  const std::vector<Ray>& rays; // primary rays
  std::vector<size_t> sample;   // indices of the rays to measure
  float footprint;              // width of a pixel at distance 1
};

/* `hits` holds one entry per ray of the view; misses in the sample are ignored. `layout` is the model's at the level of
 * the hits. Throws Cancelled. */
TrueErrors compareToTrueSurface(const TrueView& view, const std::vector<SurfaceHit>& hits, const PatchLayout& layout,
                                unsigned threads);

} // namespace cbvh
