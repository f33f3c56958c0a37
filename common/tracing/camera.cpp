// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tracing/camera.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace programs {

Camera::Camera(Vec3f eye, Vec3f lookAt, Vec3f up, float fov, ImageSize size)
  : origin(eye),
    target(lookAt),
    fieldOfView(fov),
    image(size) {
  forward = normalize(lookAt - eye);
  const Vec3f axis = normalize(up); // of any length
  for (Vec3f other : {axis, Vec3f{axis.y, axis.z, axis.x}, Vec3f{axis.x, -axis.y, axis.z}})
    if (length(right) < 1e-6f) // the view is along the previous one
      right = cross(forward, other);
  right = normalize(right);
  down = cross(forward, right);
  pixel = 2.0f * std::tan(0.5f * fov * float(M_PI) / 180.0f) / float(size.height);
}

Camera Camera::fit(const std::vector<Vec3f>& points, float radius, const ViewHints& hints, float fov, ImageSize size) {
  /* In axes of the camera, a ball at (x,y,z) is left of the right border plane of an eye at (ex,ey,ez) if x - z t +
   * radius / cos <= ex - ez t, where t is the tangent of half the field of view; likewise for the other planes. The
   * maxima of the left sides for two opposite planes give the nearest eye. From there, the narrowest pair of planes
   * that contains all balls is centered in the picture. */
  constexpr float rim = 0.96f;
  const Vec3f direction = normalize(hints.direction);
  const Camera probe(-direction, {}, hints.up, fov, size);
  const float tans[2] = {rim * 0.5f * probe.pixel * float(size.width), rim * 0.5f * probe.pixel * float(size.height)};
  const Vec3f axes[2] = {probe.right, probe.down};
  const auto sides = [&](Vec3f axis, float tan) {
    const float grow = radius * std::sqrt(1.0f + tan * tan);
    Vec2f side{-INFINITY, -INFINITY};
    for (const Vec3f& p : points) {
      const float x = dot(p, axis), z = dot(p, direction);
      side.x = std::max(side.x, x - z * tan + grow);
      side.y = std::max(side.y, -x - z * tan + grow);
    }
    return side;
  };
  float middle[2], nearest = INFINITY;
  for (int i = 0; i < 2; i++) {
    const Vec2f side = sides(axes[i], tans[i]);
    nearest = std::min(nearest, -0.5f * (side.x + side.y) / tans[i]);
  }
  for (int i = 0; i < 2; i++) {
    float narrow = 0.0f, wide = tans[i];
    for (int step = 0; step < 20; step++) {
      const float tan = 0.5f * (narrow + wide);
      const Vec2f side = sides(axes[i], tan);
      (side.x + side.y <= -2.0f * nearest * tan ? wide : narrow) = tan;
    }
    const Vec2f side = sides(axes[i], wide);
    middle[i] = 0.5f * (side.x - side.y);
  }
  const Vec3f eye = middle[0] * axes[0] + middle[1] * axes[1] + nearest * direction;
  Box3f box;
  for (const Vec3f& p : points) box.extend(p);
  return Camera(eye, eye + std::max(dot(box.center() - eye, direction), box.diagonal() * 1e-3f) * direction, hints.up,
                fov, size);
}

Vec3f Camera::direction(float pixelX, float pixelY) const {
  const float x = (pixelX + 0.5f - 0.5f * float(image.width)) * pixel;
  const float y = (pixelY + 0.5f - 0.5f * float(image.height)) * pixel;
  return normalize(forward + x * right + y * down);
}

std::string Camera::description() const {
  std::string text;
  for (const float x : {origin.x, origin.y, origin.z, target.x, target.y, target.z, fieldOfView}) {
    char digits[32];
    char* const end = std::to_chars(digits, digits + sizeof(digits), x).ptr; // as many as distinguish floats
    text += (text.empty() ? "" : ",") + std::string(digits, end);
  }
  return text;
}

} // namespace programs
