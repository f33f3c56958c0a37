// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/motion.h"
#include "basics/error.h"
#include "basics/setting_name.h"

#include <algorithm>
#include <cmath>

namespace programs {
namespace {

Vec3f rotated(Vec3f p, Vec3f center, Vec3f axis, float angle) {
  const Vec3f d = p - center;
  const float c = std::cos(angle), s = std::sin(angle);
  return center + c * d + s * cross(axis, d) + ((1 - c) * dot(axis, d)) * axis;
}

Vec3f pose(const std::string& name, Vec3f p, const Box3f& bounds, float angle) {
  const Vec3f middle = 0.5f * (bounds.lower + bounds.upper), size = bounds.upper - bounds.lower;
  const float height = (p.y - bounds.lower.y) / std::max(size.y, 1e-20f); // 0 to 1
  if (name == "turn") return rotated(p, middle, {0, 1, 0}, angle);
  if (name == "twist") return rotated(p, middle, {0, 1, 0}, angle * height);
  if (name == "bend") return rotated(p, {middle.x, bounds.lower.y, middle.z}, {0, 0, 1}, angle * height * height);
  /* Legs swing about the hip, along the longer horizontal axis. */
  const bool isLong = size.x > size.z;
  const float width = std::max(isLong ? size.z : size.x, 1e-20f);
  const float side = (isLong ? p.z - middle.z : p.x - middle.x) / width; // -0.5 to 0.5
  const float below = std::clamp((0.5f - height) / 0.3f, 0.0f, 1.0f);
  const float swing = below * below * (3 - 2 * below) * std::clamp(6 * side, -1.0f, 1.0f);
  const Vec3f hip{middle.x, bounds.lower.y + 0.5f * size.y, middle.z};
  return rotated(p, hip, isLong ? Vec3f{0, 0, 1} : Vec3f{1, 0, 0}, angle * swing);
}

} // namespace

const std::vector<std::string>& motionNames() {
  static const std::vector<std::string> names{"turn", "bend", "twist", "walk"};
  return names;
}

void validateMotion(const MotionSettings& settings) {
  const std::vector<std::string>& names = motionNames();
  if (std::find(names.begin(), names.end(), settings.name) == names.end())
    throw Error(settingName("motion") + ": unknown motion '" + settings.name + "': expected turn, bend, twist or walk");
  if (settings.steps < 2 || settings.steps > 129)
    throw Error(settingName("steps") + ": " + std::to_string(settings.steps) + " time steps: expected 2 to 129");
}

std::vector<Vec3f> poseVertices(const std::string& name, const std::vector<Vec3f>& positions, float degrees) {
  Box3f bounds;
  for (const Vec3f& p : positions) bounds.extend(p);
  std::vector<Vec3f> result;
  for (const Vec3f& p : positions) result.push_back(pose(name, p, bounds, float(M_PI) / 180 * degrees));
  return result;
}

void addMotion(Model& model, const MotionSettings& settings) {
  validateMotion(settings);
  model.poses.clear();
  for (int i = 1; i < settings.steps; i++) {
    const float degrees = settings.degrees * float(i) / float(settings.steps - 1);
    model.poses.push_back(poseVertices(settings.name, model.cage.positions, degrees));
  }
}

} // namespace programs
