// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The blade is in the plane z = 0 with its cutting edge inside the bend; the shaft is parallel to y. */

#include "scenes/scythe.h"
#include "basics/parallel.h"
#include "scenes/baked_heights.h"
#include "scenes/cage_parts.h"
#include "scenes/noise.h"

namespace programs {
namespace {

constexpr int bladeStations = 9;
constexpr float bladeRadius = 3.0f, bladeAngle = 1.75f;

/* Shaft: t = 0, tip: t = 1. */
Vec3f bladeMiddle(float t) {
  const float angle = 0.5f * float(M_PI) + 0.25f - bladeAngle * t;
  return {bladeRadius * std::cos(angle) * 1.25f + 0.9f, bladeRadius * std::sin(angle) - 1.1f, 0.0f};
}

Vec3f bladeTangent(float t) { return normalize(bladeMiddle(t + 1e-3f) - bladeMiddle(t - 1e-3f)); }

float bladeWidth(float t) {
  return 0.52f * std::pow(1.0f - t, 0.6f) * (0.75f + 0.5f * std::min(1.0f, 3.0f * t)) + 0.012f;
}

/* Nearest t on the middle line. */
float alongBlade(Vec3f p) {
  float best = 0.0f, distance = INFINITY;
  for (int i = 0; i <= 64; i++) {
    const float t = float(i) / 64.0f, d = length(p - bladeMiddle(t));
    if (d < distance) {
      distance = d;
      best = t;
    }
  }
  for (int i = 0; i < 3; i++) // Newton's method
  {
    const Vec3f tangent = bladeMiddle(best + 1e-3f) - bladeMiddle(best - 1e-3f);
    best += 2e-3f * dot(p - bladeMiddle(best), tangent) / dot(tangent, tangent);
  }
  return std::min(std::max(best, 0.0f), 1.0f);
}

/* Notches of a hammered edge and ribs along the spine, decreasing towards the tip. */
float bladeHeight(Vec3f p) {
  const float t = alongBlade(p);
  const Vec3f outwards = cross(bladeTangent(t), Vec3f{0, 0, -1});
  const float across = dot(p - bladeMiddle(t), outwards) / bladeWidth(t);
  const float thin = std::pow(1.0f - t, 0.7f);
  const float notches = std::pow(std::abs(std::sin(19.0f * t + 0.8f * across)), 3.0f);
  const float hammered = gradientNoise(4.5f * p, 3) + 0.5f * gradientNoise(11.0f * p, 4);
  const float rib = std::sin(9.0f * across + 2.0f * gradientNoise(2.0f * p, 5));
  return neutralHeight + thin * (0.42f * notches * std::abs(across) + 0.16f * hammered + 0.1f * rib);
}

/* Bark, with rings where the blade is bound. */
float shaftHeight(Vec3f p) {
  const float bark = gradientNoise({7.0f * p.x, 1.6f * p.y, 7.0f * p.z}, 6);
  const float rings = p.y > 1.2f ? std::pow(std::abs(std::sin(14.0f * p.y)), 4.0f) : 0.0f;
  return neutralHeight + 0.12f * bark + 0.16f * rings;
}

} // namespace

Model makeScythe(float amplitude, int threads) {
  Model model;
  model.name = "scythe";
  std::vector<Station> blade;
  for (int i = 0; i < bladeStations; i++) {
    const float t = float(i) / float(bladeStations - 1), w = bladeWidth(t);
    const Vec3f outwards = cross(bladeTangent(t), Vec3f{0, 0, -1});
    blade.push_back({bladeMiddle(t), w * outwards, cross(bladeTangent(t), outwards) * (0.22f * w + 0.004f)});
  }
  appendTube(model.cage, blade, 8);
  const size_t bladeFaces = model.cage.numFaces();

  std::vector<Station> shaft;
  constexpr int shaftStations = 8;
  for (int i = 0; i < shaftStations; i++) {
    const float t = float(i) / float(shaftStations - 1);
    const float r = 0.17f + 0.03f * std::sin(5.0f * t);
    shaft.push_back({{0.15f + 0.35f * std::sin(3.0f * t) * (1.0f - t), -4.2f + 6.6f * t, 0.0f}, {r, 0, 0}, {0, 0, -r}});
  }
  appendTube(model.cage, shaft, 8);
  model.cage.name = "scythe";
  const auto height = [&](const LimitPoint& p) {
    return p.face < bladeFaces ? bladeHeight(p.position) : shaftHeight(p.position);
  };
  model.displacement = displaceByBake(model.cage, 128, amplitude * model.cage.bounds().diagonal(),
                                      {"scythe: relief", threadCount(threads), height});
  model.view.direction = {-0.3f, -0.15f, -1.0f};
  model.view.closePoint = {0.85f, 0.4f};
  model.view.closeDistance = 0.36f;
  return model;
}

} // namespace programs
