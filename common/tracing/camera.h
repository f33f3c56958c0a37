// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A pinhole camera with square pixels. */

#include "surface/view_hints.h"
#include "tracing/image_size.h"

#include <string>
#include <vector>

namespace cbvh {

class Camera
{
public:
  /* fov: vertical, in degrees. */
  Camera(Vec3f eye, Vec3f lookAt, Vec3f up, float fov, ImageSize size);

  /* All points, each a ball of some radius, in view along the hint's direction, as
   * large as can be with a narrow rim. */
  static Camera fit(const std::vector<Vec3f>& points, float radius, const ViewHints& hints, float fov, ImageSize size);

  /* Direction through the centre of a pixel, of length 1. */
  Vec3f direction(float pixelX, float pixelY) const;

  Vec3f viewDirection() const { return forward; } // into the middle of the picture, of length 1
  Vec3f upDirection() const { return -down; }     // of the picture, likewise

  /* Width of a pixel at a distance of 1; that at distance t is t times this. */
  float footprint() const { return pixel; }

  Vec3f eye() const { return origin; }
  Vec3f lookAt() const { return target; }
  float fov() const { return fieldOfView; }
  ImageSize size() const { return image; }
  std::string description() const; // as the --view option takes it

private:
  Vec3f origin, target, right, down, forward;
  float pixel, fieldOfView;
  ImageSize image;
};

} // namespace cbvh
