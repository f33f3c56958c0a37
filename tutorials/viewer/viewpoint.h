// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Where the user stands and what is looked at, and how mouse and keys move both. */

#include "tracing/camera.h"

namespace cbvh {

class Viewpoint
{
public:
  /* camera: that of the start. up: of the model; the camera never tilts against it. */
  Viewpoint(const Camera& camera, Vec3f up);

  Camera camera(ImageSize size) const { return Camera(eye, target, up, fieldOfView, size); }

  Vec3f position() const { return eye; }
  Vec3f direction() const { return normalize(target - eye); }
  float distance() const { return length(target - eye); } // of what is looked at
  float fov() const { return fieldOfView; }

  /* Turns the view to the right and upwards, in radians: about the target, or on the spot. */
  void orbit(float right, float upwards);
  void look(float right, float upwards);

  /* Turns to a point, which orbit turns about from then on. */
  void lookAt(Vec3f point);

  /* Walks, in world units. */
  void move(float right, float forward);

  /* Moves sideways so that what lies `depth` before the eye follows the mouse by so many pixels. */
  void pan(float pixelsRight, float pixelsDown, float depth, ImageSize size);

  /* Brings all points `factor` times as far away as they are, keeping `point` in its pixel. */
  void zoom(Vec3f point, float factor);

  void set(const Camera& camera);

private:
  Vec3f right() const;
  Vec3f turned(float right, float upwards) const;

  Vec3f eye, target, up;
  float fieldOfView;
};

} // namespace cbvh
