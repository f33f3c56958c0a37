// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Turns hits and errors into pictures. */

#include "building/surface_hit.h"
#include "pictures/image.h"
#include "tracing/ray.h"

#include <vector>

namespace cbvh {

/* What colour hits have. */
enum class HitColors
{
  Neutral, // grey from both sides
  Sides,   // magenta where the normal points away from the viewer: a wrong sign, or the inside of the surface
};

/* Two lights and the geometric normal as the representation reports it, turned towards
 * the viewer where it points away. */
class HitShader
{
public:
  /* middle: direction of the ray in the middle of the picture, of length 1. */
  HitShader(Vec3f middle, Vec3f up, HitColors colors = HitColors::Neutral);

  /* Colour of a hit, linear. */
  Vec3f color(const Ray& ray, const SurfaceHit& hit) const;

private:
  Vec3f up, key, fill; // towards the lights
  HitColors colors;
};

/* What a picture shows behind the surface. fraction: 0 at its top, 1 at its bottom. */
Vec3f backgroundColor(float fraction);

/* values: a pixel each, from 0, black, to 1, white. */
Image greyPicture(ImageSize size, const std::vector<float>& values);

/* Ambient occlusion of GRID, of another representation, and four times their difference,
 * side by side: grey for none, brighter where the representation lets more light in.
 * grid, light: a value a pixel, as ambientOcclusion makes them. */
Image compareAmbient(ImageSize size, const std::vector<float>& grid, const std::vector<float>& light);

/* Colour of one error of pixelErrors, see errorHeatMap. */
Vec3f errorColor(float error);

/* The paper's figure 10: from blue, no error, to pink at 5 pixels and beyond; black
 * where the representation hits and the reference misses. Orange is the opposite, a
 * miss; white the background.
 * errors: as pixelErrors makes them. */
Image errorHeatMap(ImageSize size, const std::vector<float>& errors);

} // namespace cbvh
