// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Distances between the hits of two representations, as in the paper: divided by the width of a pixel at the
 * reference. */

#include "building/surface_hit.h"
#include "measure/error_summary.h"
#include "surface/cage.h"

#include <cstddef>
#include <vector>

namespace programs {

/* Errors of rays that hit in both. */
struct HitErrors : ErrorSummary {
  size_t rays = 0;
  size_t bothHit = 0;
  size_t falseHits = 0; // hits where the reference misses
  size_t misses = 0;    // misses where the reference hits
  /* Errors above 5 pixels usually mean another sheet of the surface, at a silhouette or through a crack. inlierRmse
   * and bias exclude them, because a few would dominate. */
  size_t outliers = 0;
  double inlierRmse = 0;
  double bias = 0; // mean signed distance along the ray in pixels, positive behind the reference
};

/* `reference` and `hits` hold one entry per ray. Ray directions have unit length; `footprint` is the width of a
 * pixel at distance 1. `layout` is the model's at the level of both. */
HitErrors compareHits(const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& hits, float footprint,
                      const PatchLayout& layout);

constexpr float outlierPixels = 5.0f;

/* Correct if a ray slipped between two triangles in one of the traversals. */
std::vector<SurfaceHit> nearerHits(const std::vector<SurfaceHit>& a, const std::vector<SurfaceHit>& b);

/* Special values of pixelErrors. */
constexpr float falseHitError = -1.0f;
constexpr float missError = -2.0f;
constexpr float backgroundError = -3.0f;

/* Error per ray in pixels, or one of the values above unless both hit. */
std::vector<float> pixelErrors(const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& hits,
                               float footprint);

} // namespace programs
