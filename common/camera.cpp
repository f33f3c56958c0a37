// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "camera.h"

#include <cstdio>

namespace cbvh {

Camera::Camera(Vec3f eye, Vec3f lookAt, Vec3f up, float fov, ImageSize size)
  : origin(eye), target(lookAt), fieldOfView(fov), image(size)
{
  forward = normalize(lookAt - eye);
  right = cross(forward, up);
  if (length(right) < 1e-6f) // looking along the up vector
    right = cross(forward, Vec3f{up.y, up.z, up.x});
  right = normalize(right);
  down = cross(forward, right);
  pixel = 2.0f * std::tan(0.5f * fov * float(M_PI) / 180.0f) / float(size.height);
}

Camera Camera::wholeBox(const Box3f& box, const ViewHints& hints, float fov, ImageSize size)
{
  /* Far enough for each corner: one at depth z and offset (x,y) from the axis is in
   * view from distance d when |y| <= (d + z) tan, and likewise for x. */
  const Vec3f center = box.center();
  const Vec3f direction = normalize(hints.direction);
  const Camera probe(center - direction, center, hints.up, fov, size);
  const float tanY = 0.5f * probe.pixel * float(size.height), tanX = 0.5f * probe.pixel * float(size.width);
  float distance = 0.0f;
  for (int i = 0; i < 8; i++)
  {
    const Vec3f corner{i & 1 ? box.upper.x : box.lower.x, i & 2 ? box.upper.y : box.lower.y,
                       i & 4 ? box.upper.z : box.lower.z};
    const Vec3f c = corner - center;
    const float x = std::abs(dot(c, probe.right)), y = std::abs(dot(c, probe.down)), z = dot(c, direction);
    distance = std::max(distance, std::max(x / tanX, y / tanY) - z);
  }
  return Camera(center - direction * (1.02f * distance), center, hints.up, fov, size);
}

Vec3f Camera::direction(float pixelX, float pixelY) const
{
  const float x = (pixelX + 0.5f - 0.5f * float(image.width)) * pixel;
  const float y = (pixelY + 0.5f - 0.5f * float(image.height)) * pixel;
  return normalize(forward + x * right + y * down);
}

std::string Camera::description() const
{
  char text[160];
  std::snprintf(text, sizeof(text), "%g,%g,%g,%g,%g,%g,%g", origin.x, origin.y, origin.z, target.x, target.y, target.z,
                fieldOfView);
  return text;
}

} // namespace cbvh
