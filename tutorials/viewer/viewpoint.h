// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The user's position and target, and their movement by mouse and keys. */

#include "tracing/camera.h"

namespace cbvh {

class Viewpoint
{
public:
  /* Starts at a camera. `up` is the model's up direction; the camera never rolls. */
  Viewpoint(const Camera& camera, Vec3f up);

  Camera camera(ImageSize size) const { return Camera(eye, target, up, fieldOfView, size); }

  Vec3f position() const { return eye; }
  Vec3f direction() const { return normalize(target - eye); }
  float distance() const { return length(target - eye); } // from the target
  float fov() const { return fieldOfView; }

  /* Rotate the view to the right and upwards, in radians: about the target, or about the eye. */
  void orbit(float right, float upwards);
  void look(float right, float upwards);

  /* Turns to a point, which becomes the target. */
  void lookAt(Vec3f point);

  /* Moves eye and target, in world units. */
  void move(float right, float forward);

  /* Moves sideways so that points at distance `depth` follow the mouse by a number of pixels. */
  void pan(float pixelsRight, float pixelsDown, float depth, ImageSize size);

  /* Multiplies the distance of all points by `factor` and keeps `point` in its pixel. */
  void zoom(Vec3f point, float factor);

  void set(const Camera& camera);

private:
  Vec3f right() const;
  Vec3f turned(float right, float upwards) const;

  Vec3f eye, target, up;
  float fieldOfView;
};

} // namespace cbvh
