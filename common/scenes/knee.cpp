// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Thigh and shank lie in the plane z = 0; the knee points to +x. */

#include "scenes/knee.h"
#include "basics/parallel.h"
#include "scenes/baked_heights.h"
#include "scenes/cage_parts.h"
#include "scenes/noise.h"

namespace programs {
namespace {

struct Section {
  float x, y, front, back, side; // center; half axes to the front, the back and along z
};

/* From hip to foot, with few sections at the bend. */
constexpr Section sections[] = {
    {-3.0f, 1.45f, 0.75f, 0.7f, 0.8f},    {-2.5f, 1.25f, 0.95f, 0.8f, 0.95f},   {-1.6f, 0.9f, 0.95f, 0.68f, 0.9f},
    {-0.75f, 0.55f, 0.72f, 0.45f, 0.68f}, {-0.15f, 0.28f, 0.55f, 0.32f, 0.56f}, {0.12f, -0.1f, 0.55f, 0.3f, 0.56f},
    {0.0f, -0.55f, 0.42f, 0.36f, 0.5f},   {-0.35f, -1.2f, 0.36f, 0.66f, 0.52f}, {-0.75f, -1.9f, 0.3f, 0.5f, 0.42f},
    {-1.1f, -2.6f, 0.25f, 0.27f, 0.28f},  {-1.3f, -3.05f, 0.3f, 0.3f, 0.34f},   {-1.25f, -3.4f, 0.5f, 0.3f, 0.42f},
    {-1.2f, -3.6f, 0.55f, 0.32f, 0.45f}};

/* A kneecap with plates, wrinkles at the bend, elsewhere muscles and skin. */
float kneeHeight(Vec3f p) {
  const float near = std::exp(-dot(p - Vec3f{0.45f, 0.1f, 0}, p - Vec3f{0.45f, 0.1f, 0}) / 0.3f);
  const Vec3f noise{gradientNoise(2.0f * p, 1), gradientNoise(2.0f * p, 2), gradientNoise(2.0f * p, 3)};
  const Vec3f warped = p + 0.08f * noise;
  const CellNoise plate = cellNoise(3.4f * warped, 4);
  const float plates =
      smoothstep(0.0f, 0.25f, plate.second - plate.nearest) * (1.0f - 0.5f * plate.nearest * plate.nearest);
  const CellNoise cell = cellNoise(9.0f * warped, 5);
  const float scales =
      smoothstep(0.0f, 0.35f, cell.second - cell.nearest) * (1.0f - 0.5f * cell.nearest * cell.nearest);
  /* Around the inside of the bend. */
  const float angle = std::atan2(p.y + 0.5f, p.x + 1.0f);
  const float bend = std::exp(-(p.x * p.x + p.y * p.y) / 0.9f);
  const float rings = std::abs(std::sin(11.0f * angle + 1.5f * gradientNoise(1.5f * p, 6)));
  const float veins = smoothstep(0.25f, 0.0f, std::abs(gradientNoise({1.5f * p.x, 0.7f * p.y, 1.5f * p.z}, 7)));
  return 0.35f + near * (0.3f + 0.3f * plates) + (1.0f - near) * (0.12f * scales + 0.2f * veins) +
         0.2f * bend * (1.0f - near) * rings + 0.08f * gradientNoise(1.2f * p, 8);
}

} // namespace

Model makeKnee(float amplitude, int threads) {
  constexpr size_t n = sizeof(sections) / sizeof(sections[0]);
  Model model;
  model.name = "knee";
  std::vector<Station> stations;
  for (size_t i = 0; i < n; i++) {
    const Section &s = sections[i], &before = sections[i ? i - 1 : 0], &after = sections[std::min(i + 1, n - 1)];
    const Vec3f tangent = normalize(Vec3f{after.x - before.x, after.y - before.y, 0});
    const Vec3f front = cross(Vec3f{0, 0, 1}, tangent); // towards +x on the way down
    const float a = 0.5f * (s.front + s.back);
    const Vec3f center = Vec3f{s.x, s.y, 0} + 0.5f * (s.front - s.back) * front;
    stations.push_back({center, a * front, s.side * cross(tangent, front)});
  }
  appendTube(model.cage, stations, 8);
  model.cage.name = "knee";
  const auto height = [](const LimitPoint& p) { return kneeHeight(p.position); };
  model.displacement = displaceByBake(model.cage, 128, amplitude * model.cage.bounds().diagonal(),
                                      {"knee: skin", threadCount(threads), height});
  model.view.direction = {-0.45f, -0.1f, -0.9f};
  model.view.closePoint = {0.72f, 0.42f};
  model.view.closeDistance = 0.34f;
  return model;
}

} // namespace programs
