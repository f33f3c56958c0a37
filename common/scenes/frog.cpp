// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* x points to the head, y up, z to the frog's right. */

#include "scenes/frog.h"
#include "basics/parallel.h"
#include "scenes/baked_heights.h"
#include "scenes/cage_parts.h"
#include "scenes/implicit_cage.h"
#include "scenes/noise.h"

namespace programs {
namespace {

std::vector<Capsule> frogBody() {
  std::vector<Capsule> body;
  for (float side : {-1.0f, 1.0f}) {
    const auto add = [&](Vec3f a, Vec3f b, float ra, float rb, float smooth, bool carve = false) {
      body.push_back({{a.x, a.y, a.z * side}, {b.x, b.y, b.z * side}, ra, rb, smooth, carve});
    };
    add({-0.9f, 0.85f, 0.3f}, {0.5f, 1.15f, 0.4f}, 0.75f, 0.8f, 0.3f);     // half of the trunk
    add({0.6f, 1.35f, 0.35f}, {1.35f, 1.4f, 0.3f}, 0.72f, 0.5f, 0.3f);     // head
    add({0.95f, 1.98f, 0.56f}, {1.0f, 2.0f, 0.58f}, 0.36f, 0.36f, 0.08f);  // eye
    add({-0.9f, 0.75f, 0.95f}, {0.15f, 0.6f, 1.45f}, 0.48f, 0.32f, 0.2f);  // thigh, folded
    add({0.15f, 0.55f, 1.45f}, {-0.85f, 0.25f, 1.5f}, 0.3f, 0.22f, 0.1f);  // shank
    add({-0.85f, 0.2f, 1.5f}, {0.1f, 0.1f, 1.75f}, 0.22f, 0.19f, 0.08f);   // foot
    add({0.75f, 0.8f, 0.85f}, {0.85f, 0.45f, 1.15f}, 0.32f, 0.25f, 0.15f); // arm
    add({0.85f, 0.45f, 1.15f}, {1.15f, 0.12f, 1.1f}, 0.24f, 0.2f, 0.1f);
    for (float spread : {-0.42f, 0.0f, 0.42f}) {
      add({0.1f, 0.1f, 1.75f}, {0.8f, 0.08f, 1.75f + spread}, 0.19f, 0.17f, 0.05f);
      add({1.15f, 0.12f, 1.1f}, {1.75f, 0.08f, 1.1f + spread}, 0.19f, 0.17f, 0.05f);
    }
    add({2.05f, 1.15f, 0.0f}, {1.1f, 1.12f, 1.1f}, 0.13f, 0.13f, 0.05f, true); // mouth
  }
  return body;
}

float spike(float x) {
  const float s = std::sin(float(M_PI) * x);
  return s * s;
}

} // namespace

Model makeFrog(float amplitude, int threads) {
  constexpr float voxel = 0.24f;
  Model model;
  model.name = "frog";
  model.cage = makeImplicitCage(frogBody(), [](int, float) { return voxel; });
  model.cage.name = "frog";

  /* Spikes are longest along the back. Below, on feet and on eyes there are none. */
  std::vector<float> lengths;
  const Cage& cage = model.cage;
  for (unsigned face = 0; face < cage.numFaces(); face++) {
    Vec3f p[4];
    for (unsigned i = 0; i < 4; i++) p[i] = cage.positions[cage.faceIndices[4 * face + i]];
    const Vec3f center = 0.25f * (p[0] + p[1] + p[2] + p[3]);
    const Vec3f normal = normalize(cross(p[2] - p[0], p[3] - p[1]));
    const uint32_t random = hashCell(int(face), 3, 5, 7);
    const bool onEye = length(center - Vec3f{0.98f, 1.99f, center.z > 0.0f ? 0.57f : -0.57f}) < 0.42f;
    const bool bare = onEye || center.y < 0.4f || normal.y < -0.1f || random % 100 < 35;
    const float length = (0.25f + 0.75f * std::max(normal.y, 0.0f)) * (0.6f + 0.4f * float(random >> 24) / 255.0f);
    lengths.push_back(bare ? 0.0f : length);
  }
  const auto height = [&](const LimitPoint& p) {
    const float s = spike(p.u) * spike(p.v);
    const float warts = 0.02f * gradientNoise(3.0f * p.position, 2);
    return neutralHeight + warts + lengths[p.face] * s * s * s * s * s;
  };
  model.displacement =
      displaceByBake(cage, 128, amplitude * cage.bounds().diagonal(), {"frog: spikes", threadCount(threads), height});
  model.view.direction = {-0.75f, -0.42f, -0.72f};
  model.view.closePoint = {0.52f, 0.3f};
  model.view.closeDistance = 0.3f;
  return model;
}

} // namespace programs
