// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How far hits lie from the true surface: tessellation and compression together, by
 * the same measure for every representation. */

#include "building/surface_hit.h"
#include "measure/error_summary.h"
#include "surface/true_surface.h"
#include "tracing/ray.h"

#include <cstdint>
#include <vector>

namespace cbvh {

/* Against the nearest point of the true surface. */
struct TrueErrors : ErrorSummary
{
  size_t hits = 0; // that were measured
  /* Distances in world units. */
  double rmseWorld = 0, medianWorld = 0, p99World = 0;
  /* Signed distance along the ray, in pixels, positive: behind the true surface; of
   * hits whose ray meets it within 5 pixels. The others graze it, or pass it by. */
  double rmseAlong = 0, bias = 0;
  size_t apart = 0; // those others
};

/* Indices of `count` hits drawn at random, in order; of all there are when those are
 * fewer. */
std::vector<size_t> sampleOfHits(const std::vector<SurfaceHit>& hits, size_t count, uint32_t seed);

/* What all representations are compared with in a view. */
struct TrueView
{
  const Model& model;
  const TrueSurfaces& surfaces;        // of the model
  const std::vector<Ray>& rays;        // primary
  std::vector<size_t> sample;          // of the rays
  float footprint;                     // width of a pixel at distance 1
};

/* hits: one a ray of the view; misses among the sample are left out. layout: of the
 * model at the level of the hits. Throws Cancelled. */
TrueErrors compareToTrueSurface(const TrueView& view, const std::vector<SurfaceHit>& hits, const PatchLayout& layout,
                                unsigned threads);

} // namespace cbvh
