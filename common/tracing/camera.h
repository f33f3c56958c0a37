// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A pinhole camera with square pixels. */

#include "surface/view_hints.h"
#include "tracing/image_size.h"

#include <string>
#include <vector>

namespace programs {

class Camera {
public:
  /* `fov` is the vertical field of view in degrees. */
  Camera(Vec3f eye, Vec3f lookAt, Vec3f up, float fov, ImageSize size);

  /* Returns the camera in the direction of the hints in which all points, balls of radius `radius`, fill the picture
   * up to a narrow margin. */
  static Camera fit(const std::vector<Vec3f>& points, float radius, const ViewHints& hints, float fov, ImageSize size);

  /* Unit direction; integers are centers of pixels. */
  Vec3f direction(float pixelX, float pixelY) const;

  Vec3f viewDirection() const { return forward; } // unit direction
  Vec3f upDirection() const { return -down; }     // unit direction

  /* Width of a pixel at a distance of 1. */
  float footprint() const { return pixel; }

  Vec3f eye() const { return origin; }
  Vec3f lookAt() const { return target; }
  float fov() const { return fieldOfView; }
  ImageSize size() const { return image; }
  std::string description() const; // as for --view, exact

private:
  Vec3f origin, target, right, down, forward;
  float pixel, fieldOfView;
  ImageSize image;
};

} // namespace programs
