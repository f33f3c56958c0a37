// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Secondary rays from a representation's hits and from GRID's: a surface must neither shadow itself nor let light
 * through. */

#include "building/scene_tracer.h"
#include "building/surface_hit.h"
#include "tracing/ray.h"

#include <embree3/rtcore.h>

#include <cstdint>
#include <string>
#include <vector>

namespace programs {

/* How secondary rays avoid the surface that they leave, as in renderers. */
struct RayOffset {
  float length = 0.0f; // along the geometric normal to the ray's side, world units
  float pixels = 0.0f; // the same, in pixel widths at the hit
  float ulps = 0.0f;   // tnear along the ray, in ulps of the maximum of |P| and t

  /* As in Embree's path tracer. */
  static RayOffset ofEmbree() { return {0.0f, 0.0f, 32.0f}; }
};

/* Primary rays, one per pixel. */
struct PrimaryRays {
  const std::vector<Ray>& rays;
  float footprint; // width of a pixel at distance 1
};

struct TracedHits {
  const SceneTracer& scene;
  const std::vector<SurfaceHit>& hits;
};

struct ShadowSettings {
  RayOffset offset;
  float length = INFINITY; // infinite for ambient light
  unsigned raysPerHit = 1;
  uint32_t seed = 1;
};

/* False occlusions are shadows where GRID has light; false passes are the opposite. */
struct ShadowErrors {
  size_t falseOcclusions = 0, falsePasses = 0;

  size_t sum() const { return falseOcclusions + falsePasses; }
};

/* A rate of errors is per ray of the same subset. */
struct ShadowComparison {
  size_t rays = 0;
  size_t occluded = 0; // in GRID
  ShadowErrors all;
  /* Pixels whose hits agree to a pixel width. Elsewhere the representation sees another part of the surface. */
  size_t sameHitRays = 0;
  ShadowErrors sameHitErrors;
  /* Only one of the normals points away from the viewer: rays start on the wrong side. */
  size_t flippedRays = 0;
  ShadowErrors flippedErrors;
  /* Rays from the representation's hits, traced through GRID: errors due to the position of the hit alone. */
  ShadowErrors control;
};

/* Traces the same directions from each pixel that both scenes hit: cosine-distributed about GRID's normal on the
 * side of the primary ray. Throws Canceled. */
ShadowComparison compareShadows(const TracedHits& grid, const TracedHits& tested, const PrimaryRays& primary,
                                const ShadowSettings& settings, unsigned threads);

/* Fraction of unoccluded directions per pixel, 1 for a miss. Directions are cosine-distributed about the hit's own
 * normal. Throws Canceled. */
std::vector<float> ambientOcclusion(const TracedHits& tested, const PrimaryRays& primary,
                                    const ShadowSettings& settings, unsigned threads);

} // namespace programs
