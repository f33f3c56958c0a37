// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Whether secondary rays that leave a representation's own hits see what GRID's see
 * from GRID's hits: neither a surface that shadows itself nor light that comes through. */

#include "building/scene_tracer.h"
#include "building/surface_hit.h"
#include "tracing/ray.h"

#include <embree3/rtcore.h>

#include <cstdint>
#include <string>
#include <vector>

namespace cbvh {

/* How a renderer keeps secondary rays off the surface that they leave. */
struct RayOffset
{
  float length = 0.0f;  // along the geometric normal on the ray's side, world units
  float pixels = 0.0f;  // the same, in widths of a pixel at the hit
  float ulps = 0.0f;    // tnear along the ray, in ulps of the largest of |P| and t

  /* That of Embree's own path tracer. */
  static RayOffset ofEmbree() { return {0.0f, 0.0f, 32.0f}; }
};

/* The primary rays of a picture, one a pixel. */
struct PictureRays
{
  const std::vector<Ray>& rays;
  float footprint; // width of a pixel at distance 1
};

/* A scene and its hits of them. */
struct SeenScene
{
  const SceneTracer& scene;
  const std::vector<SurfaceHit>& hits;
};

struct ShadowSettings
{
  RayOffset offset;
  float length = INFINITY; // of the secondary rays; infinite for ambient light
  unsigned raysPerHit = 1;
  uint32_t seed = 1;
};

/* A false occlusion is light where a representation says shadow, a false pass the
 * opposite. */
struct ShadowErrors
{
  size_t falseOcclusions = 0, falsePasses = 0;

  size_t sum() const { return falseOcclusions + falsePasses; }
};

struct ShadowComparison
{
  size_t rays = 0;
  size_t occluded = 0;       // of GRID's
  ShadowErrors all;
  /* Those of pixels whose hits are at the same place, to a pixel: the others see
   * another part of the surface, and are no matter of self-shadowing. */
  size_t raysOfSame = 0;
  ShadowErrors ofSame;
  /* Those of pixels whose normal is seen from behind where GRID's is not, or the opposite:
   * their rays start on the wrong side. */
  size_t raysOfTurned = 0;
  ShadowErrors ofTurned;
  /* The control: GRID's rays from the representation's hits. What is wrong with them,
   * too, is wrong with the hit, not with how a ray leaves it. */
  ShadowErrors control;
};

/* From each pixel that both hit, the same directions, of cosine distribution about
 * GRID's normal, on the side that the primary ray comes from. Throws Cancelled. */
ShadowComparison compareShadows(const SeenScene& grid, const SeenScene& seen, const PictureRays& primary,
                                const ShadowSettings& settings, unsigned threads);

/* Share of directions that are free, a value a pixel, 1 where there is no hit; of a cosine
 * distribution about the hit's own normal. Throws Cancelled. */
std::vector<float> ambientOcclusion(const SeenScene& seen, const PictureRays& primary, const ShadowSettings& settings,
                                    unsigned threads);

} // namespace cbvh
