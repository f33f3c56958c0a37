// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Ray sets for comparing representations. All representations trace the same rays, which are made once from GRID's
 * hits. */

#include "building/surface_hit.h"
#include "tracing/camera.h"
#include "tracing/crop.h"
#include "tracing/ray.h"

#include <cstdint>
#include <vector>

namespace cbvh {

enum RaySet { Coherent, Incoherent, numRaySets };

/* Returns "coherent" or "incoherent". */
const char* raySetName(RaySet set);

/* Returns the ray through a pixel. `offset` is from the center of the pixel, in pixels. */
Ray primaryRay(const Camera& camera, int x, int y, Vec2f offset = {});

/* Returns one ray per pixel, in rows. `offset` is from the centers of the pixels, in pixels. */
std::vector<Ray> primaryRays(const Camera& camera, Vec2f offset = {});

std::vector<Ray> primaryRays(const Camera& camera, const Crop& part, Vec2f offset = {});

/* Returns the coherent set: primary rays in tiles of 8 x 8 pixels, each tile in rows. If `count` is less than the
 * number of pixels and not 0, whole tiles are spread evenly over the image. `primary` is the result of primaryRays. */
std::vector<Ray> coherentRays(const std::vector<Ray>& primary, ImageSize size, size_t count);

struct BounceSettings
{
  size_t count = 0;    // largest number of rays, 0 for one per hit
  float offset = 0.0f; // from the surface along the geometric normal, world units
  uint32_t seed = 1;
};

/* Returns the incoherent set: one ray per primary hit, shuffled, with a cosine distribution about the geometric normal
 * on the side of the camera. The origin is offset along that normal, tnear is 0. `hits` is parallel to `primary`. */
std::vector<Ray> bounceRays(const std::vector<Ray>& primary, const std::vector<SurfaceHit>& hits,
                            const BounceSettings& settings);

} // namespace cbvh
