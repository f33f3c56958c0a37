// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Distances between the hits of two representations. The error is the paper's: the distance between both hit points,
 * divided by the width of a pixel at the distance of the reference. */

#include "building/surface_hit.h"
#include "measure/error_summary.h"
#include "surface/cage.h"

#include <cstddef>
#include <vector>

namespace cbvh {

/* Errors over rays for which both the reference and the representation have hits. */
struct HitErrors : ErrorSummary
{
  size_t rays = 0;
  size_t bothHit = 0;
  size_t falseHits = 0; // hits where the reference misses
  size_t misses = 0;    // misses where the reference hits
  /* Errors of more than 5 pixels usually mean another sheet of the surface, at a silhouette or through a crack. A few
   * of them dominate the RMSE, so inlierRmse and bias exclude them. */
  size_t farOff = 0;
  double inlierRmse = 0;
  double bias = 0; // mean signed distance along the ray, positive if behind the reference
};

/* Compares hits of primary rays. `reference` and `hits` hold one entry per ray, in the order of the rays. `footprint`
 * is the width of a pixel at distance 1; directions have unit length. `layout` is the model's at the level of both. */
HitErrors compareHits(const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& hits, float footprint,
                      const PatchLayout& layout);

constexpr float farOffPixels = 5.0f;

/* Returns the nearer hit of each ray. If two traversals of the same surface differ because one ray slipped between two
 * triangles, the nearer hit is the correct one. */
std::vector<SurfaceHit> nearerHits(const std::vector<SurfaceHit>& a, const std::vector<SurfaceHit>& b);

/* Special values of pixelErrors. */
constexpr float falseHitError = -1.0f;
constexpr float missError = -2.0f;
constexpr float backgroundError = -3.0f;

/* Returns the error of each ray in pixels, or one of the values above unless both hit. */
std::vector<float> pixelErrors(const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& hits,
                               float footprint);

} // namespace cbvh
