// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How far the hits of one representation lie from those of another. The error is
 * the paper's: the distance between both hit points over the width of a pixel at
 * the reference's distance. */

#include "building/surface_hit.h"
#include "measure/error_summary.h"
#include "surface/cage.h"

#include <cstddef>
#include <vector>

namespace cbvh {

/* Over rays where both hit, against the reference. */
struct HitErrors : ErrorSummary
{
  size_t rays = 0;
  size_t bothHit = 0;
  size_t falseHits = 0;        // hit where the reference misses
  size_t misses = 0;           // miss where the reference hits
  /* Rays off by more than 5 pixels, which is another sheet of the surface more often
   * than not: behind a silhouette, or through a crack. A few of them make the RMSE;
   * this is the one without them. */
  size_t farOff = 0;
  double rmseOfOthers = 0;
  double bias = 0;             // mean of the signed distance along the ray of those others, positive: behind
};

/* Compares hits of primary rays.
 *
 * reference, hits: one a ray, same rays. footprint: width of a pixel at distance 1
 * for directions of length 1. layout: of the model at the level of both. */
HitErrors compareHits(const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& hits, float footprint,
                      const PatchLayout& layout);

constexpr float farOffPixels = 5.0f;

/* The nearer hit of each ray. Two tracings of the same surface differ where one of
 * them lets a ray slip between two triangles, and then the nearer one is right. */
std::vector<SurfaceHit> nearerHits(const std::vector<SurfaceHit>& a, const std::vector<SurfaceHit>& b);

/* Special values of pixelErrors. */
constexpr float falseHitError = -1.0f;
constexpr float missError = -2.0f;
constexpr float backgroundError = -3.0f;

/* Error of each ray in pixels, or one of the values above where not both hit. */
std::vector<float> pixelErrors(const std::vector<SurfaceHit>& reference, const std::vector<SurfaceHit>& hits,
                               float footprint);

} // namespace cbvh
