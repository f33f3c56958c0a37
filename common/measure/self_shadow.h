// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compares secondary rays from a representation's own hits with secondary rays from GRID's hits: a surface must neither
 * shadow itself nor let light through. */

#include "building/scene_tracer.h"
#include "building/surface_hit.h"
#include "tracing/ray.h"

#include <embree3/rtcore.h>

#include <cstdint>
#include <string>
#include <vector>

namespace cbvh {

/* The offset with which a renderer keeps secondary rays off the surface that they leave. */
struct RayOffset
{
  float length = 0.0f;  // along the geometric normal on the ray's side, world units
  float pixels = 0.0f;  // the same, in pixel widths at the hit
  float ulps = 0.0f;    // tnear along the ray, in ulps of the maximum of |P| and t

  /* The offset of Embree's own path tracer. */
  static RayOffset ofEmbree() { return {0.0f, 0.0f, 32.0f}; }
};

/* The primary rays of a picture, one per pixel. */
struct PictureRays
{
  const std::vector<Ray>& rays;
  float footprint; // width of a pixel at distance 1
};

/* A scene and its hits of the primary rays. */
struct TracedHits
{
  const SceneTracer& scene;
  const std::vector<SurfaceHit>& hits;
};

struct ShadowSettings
{
  RayOffset offset;
  float length = INFINITY; // of the secondary rays; infinity for ambient light
  unsigned raysPerHit = 1;
  uint32_t seed = 1;
};

/* False occlusions are shadows where GRID's rays see light; false passes are the opposite. */
struct ShadowErrors
{
  size_t falseOcclusions = 0, falsePasses = 0;

  size_t sum() const { return falseOcclusions + falsePasses; }
};

struct ShadowComparison
{
  size_t rays = 0;
  size_t occluded = 0; // in GRID
  ShadowErrors all;
  /* Pixels whose hits agree to a pixel width. In other pixels the representation sees another part of the surface,
   * which is not self-shadowing. */
  size_t sameHitRays = 0;
  ShadowErrors sameHitErrors;
  /* Pixels in which only one of both normals points away from the viewer, so that rays start on the wrong side. */
  size_t flippedRays = 0;
  ShadowErrors flippedErrors;
  /* The control: rays from the representation's hits, traced through GRID. Their errors come from the position of the
   * hit, not from the way in which a ray leaves it. */
  ShadowErrors control;
};

/* Traces the same directions from each pixel that both scenes hit: cosine-distributed about GRID's normal, on the side
 * of the primary ray. Throws Cancelled. */
ShadowComparison compareShadows(const TracedHits& grid, const TracedHits& seen, const PictureRays& primary,
                                const ShadowSettings& settings, unsigned threads);

/* Returns for each pixel the fraction of unoccluded directions, 1 for a miss. Directions are cosine-distributed about
 * the hit's own normal. Throws Cancelled. */
std::vector<float> ambientOcclusion(const TracedHits& seen, const PictureRays& primary, const ShadowSettings& settings,
                                    unsigned threads);

} // namespace cbvh
