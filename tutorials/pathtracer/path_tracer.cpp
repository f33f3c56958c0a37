// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "path_tracer.h"

namespace programs {

PathView makePathView(const Camera& camera, Vec3f up, unsigned bounces, const Shutter& shutter) {
  const float width = float(camera.size().width), height = float(camera.size().height);
  const Vec3f middle = camera.direction(0.5f * (width - 1.0f), 0.5f * (height - 1.0f));
  /* In the plane at a distance of 1. */
  const auto corner = [&](float x, float y) {
    const Vec3f direction = camera.direction(x - 0.5f, y - 0.5f);
    return direction * (1.0f / dot(direction, middle));
  };
  PathView view;
  view.eye = camera.eye();
  view.corner = corner(0.0f, 0.0f);
  view.right = (corner(width, 0.0f) - view.corner) * (1.0f / width);
  view.down = (corner(0.0f, height) - view.corner) * (1.0f / height);
  view.up = normalize(up);
  /* From behind, above and left of the viewer, as in cbvh_render. */
  view.sun = normalize(-0.55f * middle + 0.75f * view.up - 0.65f * normalize(cross(middle, view.up)));
  view.width = uint32_t(camera.size().width);
  view.height = uint32_t(camera.size().height);
  view.bounces = bounces;
  view.shutterBegin = shutter.begin;
  view.shutterEnd = shutter.end;
  return view;
}

std::vector<Vec3f> PathTracer::picture() const {
  std::vector<Vec3f> pixels = sums();
  for (Vec3f& pixel : pixels) pixel = pixel * (1.0f / float(count));
  return pixels;
}

} // namespace programs
