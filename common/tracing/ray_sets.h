// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The rays that representations are compared with. Every representation traces the
 * very same ones: they are made once, from GRID's hits. */

#include "building/surface_hit.h"
#include "tracing/camera.h"
#include "tracing/crop.h"
#include "tracing/ray.h"

#include <cstdint>
#include <vector>

namespace cbvh {

enum RaySet { Coherent, Incoherent, numRaySets };

/* "coherent", "incoherent". */
const char* raySetName(RaySet set);

/* The ray through a pixel. offset: from its centre, in pixels. */
Ray primaryRay(const Camera& camera, int x, int y, Vec2f offset = {});

/* One ray a pixel, in rows. offset: from its centre, in pixels. */
std::vector<Ray> primaryRays(const Camera& camera, Vec2f offset = {});

/* The same rays of a part of the picture. */
std::vector<Ray> primaryRays(const Camera& camera, const Crop& part, Vec2f offset = {});

/* Coherent set: primary rays in tiles of 8 x 8 pixels, each tile in rows. With fewer
 * rays wanted than there are pixels, whole tiles spread evenly over the image.
 * primary: as primaryRays makes them. count: 0 for all. */
std::vector<Ray> coherentRays(const std::vector<Ray>& primary, ImageSize size, size_t count);

struct BounceSettings
{
  size_t count = 0;     // at most that many rays, 0 for one a hit
  float offset = 0.0f;  // from the surface along the geometric normal, world units
  uint32_t seed = 1;
};

/* Incoherent set: from each primary hit one ray with cosine distribution about the
 * geometric normal on the side that the camera sees, shuffled. The origin is moved
 * off the surface along that normal, tnear is 0.
 * hits: runs parallel to primary. */
std::vector<Ray> bounceRays(const std::vector<Ray>& primary, const std::vector<SurfaceHit>& hits,
                            const BounceSettings& settings);

} // namespace cbvh
