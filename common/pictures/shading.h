// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "building/surface_hit.h"
#include "pictures/image.h"
#include "tracing/ray.h"

#include <vector>

namespace programs {

enum class HitColors {
  Neutral, // gray from both sides
  Sides,   // magenta if the normal points away from the viewer
};

/* Two lights and a sky. The geometric normal is flipped towards the viewer if necessary. */
class HitShader {
public:
  /* `middle` is the unit direction through the middle of the picture. */
  HitShader(Vec3f middle, Vec3f up, HitColors colors = HitColors::Neutral);

  /* Linear. */
  Vec3f color(const Ray& ray, const SurfaceHit& hit) const;

private:
  Vec3f up, key, fill; // towards the lights
  HitColors colors;
};

/* Linear. `fraction` is 0 at the top of the picture, 1 at the bottom. */
Vec3f backgroundColor(float fraction);

/* 0 is black, 1 white. */
Image grayImage(ImageSize size, const std::vector<float>& values);

/* Three images side by side: ambient occlusion of GRID, of another representation, and four times their difference
 * (gray for none, brighter for more light). The arguments are results of ambientOcclusion. */
Image compareAmbient(ImageSize size, const std::vector<float>& grid, const std::vector<float>& light);

Vec3f errorColor(float error);

/* Colors of the paper's figure 10: blue for no error to pink for 5 pixels and more; black for false hits, orange for
 * misses, white for the background. `errors` is a result of pixelErrors. */
Image errorHeatMap(ImageSize size, const std::vector<float>& errors);

} // namespace programs
