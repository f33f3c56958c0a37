// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Primary rays, and rays that bounce off their hits. */

#include "building/surface_hit.h"
#include "tracing/camera.h"
#include "tracing/crop.h"
#include "tracing/ray.h"

#include <cstdint>
#include <vector>

namespace programs {

enum RaySet { Coherent, Incoherent, numRaySets };

/* "coherent" or "incoherent" */
const char* raySetName(RaySet set);

/* `offset` is from the center of the pixel, in pixels. */
Ray primaryRay(const Camera& camera, int x, int y, Vec2f offset = {});

/* One ray per pixel, in rows; `offset` as above. */
std::vector<Ray> primaryRays(const Camera& camera, Vec2f offset = {});

std::vector<Ray> primaryRays(const Camera& camera, const Crop& part, Vec2f offset = {});

/* Primary rays in tiles of 8 x 8 pixels. A `count` that is not 0 spreads that many rays, in whole tiles, evenly over
 * the image. `primary` comes from primaryRays. */
std::vector<Ray> coherentRays(const std::vector<Ray>& primary, ImageSize size, size_t count);

struct BounceSettings {
  size_t count = 0;    // at most, 0 for one per hit
  float offset = 0.0f; // from the surface along the geometric normal, world units
  uint32_t seed = 1;
};

/* One ray per primary hit with a normal, shuffled, cosine-distributed about the geometric normal on the camera's side.
 * The origin is offset along that normal; tnear is 0. `hits` is parallel to `primary`. */
std::vector<Ray> bounceRays(const std::vector<Ray>& primary, const std::vector<SurfaceHit>& hits,
                            const BounceSettings& settings);

} // namespace programs
