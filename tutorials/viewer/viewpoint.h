// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The user's position and target. */

#include "tracing/camera.h"

namespace programs {

class Viewpoint {
public:
  /* `up` is the model's; the camera never rolls. */
  Viewpoint(const Camera& camera, Vec3f up);

  Camera camera(ImageSize size) const { return Camera(eye, target, up, fieldOfView, size); }

  Vec3f position() const { return eye; }
  Vec3f direction() const { return normalize(target - eye); }
  float distance() const { return length(target - eye); } // from the target
  float fov() const { return fieldOfView; }

  /* Rotate the view, in radians: about the target, or about the eye. */
  void orbit(float right, float upwards);
  void look(float right, float upwards);

  /* The point becomes the target. */
  void lookAt(Vec3f point);

  /* Moves eye and target, in world units. */
  void move(float right, float forward);

  /* Moves points at distance `depth` by a number of pixels. */
  void pan(float pixelsRight, float pixelsDown, float depth, ImageSize size);

  /* Scales all distances by `factor` and keeps `point` in its pixel. Does nothing at the limits of floats. */
  void zoom(Vec3f point, float factor);

  void set(const Camera& camera);

private:
  Vec3f right() const;
  Vec3f turned(float right, float upwards) const;

  Vec3f eye, target, up;
  float fieldOfView;
};

} // namespace programs
