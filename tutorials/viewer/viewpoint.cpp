// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "viewpoint.h"

namespace programs {
namespace {

/* Rodrigues' rotation about a unit axis. */
Vec3f rotate(Vec3f v, Vec3f axis, float angle) {
  const float c = std::cos(angle), s = std::sin(angle);
  return c * v + s * cross(axis, v) + ((1.0f - c) * dot(axis, v)) * axis;
}

} // namespace

Viewpoint::Viewpoint(const Camera& camera, Vec3f up) : up(normalize(up)) { set(camera); }

void Viewpoint::set(const Camera& camera) {
  eye = camera.eye();
  target = camera.lookAt();
  fieldOfView = camera.fov();
}

/* Same axis as in Camera, also for views along the up vector. */
Vec3f Viewpoint::right() const {
  const Vec3f r = cross(direction(), up);
  return length(r) < 1e-6f ? normalize(cross(direction(), Vec3f{up.y, up.z, up.x})) : normalize(r);
}

Vec3f Viewpoint::turned(float rightwards, float upwards) const {
  /* Avoids the poles, where the picture would spin. */
  constexpr float pole = 0.001f * float(M_PI);
  const float now = std::acos(std::min(std::max(dot(direction(), up), -1.0f), 1.0f)); // angle to up
  const float then = std::min(std::max(now - upwards, pole), float(M_PI) - pole);
  return rotate(rotate(direction(), right(), now - then), up, -rightwards);
}

void Viewpoint::orbit(float rightwards, float upwards) { eye = target - distance() * turned(rightwards, upwards); }

void Viewpoint::look(float rightwards, float upwards) { target = eye + distance() * turned(rightwards, upwards); }

void Viewpoint::lookAt(Vec3f point) {
  if (length(point - eye) > 0.0f) target = point;
}

void Viewpoint::move(float rightwards, float forward) {
  const Vec3f step = rightwards * right() + forward * direction();
  eye += step;
  target += step;
}

void Viewpoint::pan(float pixelsRight, float pixelsDown, float depth, ImageSize size) {
  const Vec3f down = cross(direction(), right());
  const Vec3f step = -(camera(size).footprint() * depth) * (pixelsRight * right() + pixelsDown * down);
  eye += step;
  target += step;
}

void Viewpoint::zoom(Vec3f point, float factor) {
  const Vec3f newEye = point + factor * (eye - point), newTarget = point + factor * (target - point);
  /* Limits for the precision of floats: not too close to the target, and not too far away. */
  const float distance = length(newTarget - newEye), reach = length(newTarget) + length(newEye);
  if (factor < 1.0f ? distance > 1e-4f * reach : reach < 1e15f) {
    eye = newEye;
    target = newTarget;
  }
}

} // namespace programs
