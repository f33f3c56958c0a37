// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "scenes/herd.h"
#include "scenes/motion.h"
#include "scenes/noise.h"

namespace programs {

/* Offset rows with some disorder; all walk in about the same direction, each in its own pose. A copy is about 11
 * long and 4 wide. */
Model makeHerd(const TrexSettings& settings, int count) {
  constexpr float spacingX = 10.5f, spacingZ = 6.0f;
  Model model = makeTrex(settings);
  model.name = "herd";
  model.copies.clear();
  const int perRow = std::max(1, int(std::lround(std::sqrt(float(count) * 1.4f))));
  for (int i = 0; i < count; i++) {
    const int row = i / perRow, column = i % perRow;
    const auto random = [&](uint32_t seed) { return float(hashCell(i, 0, 0, seed) & 1023) / 1023.0f - 0.5f; };
    Placement copy;
    copy.origin = {-spacingX * float(row) + 2.2f * random(1), 0.0f,
                   spacingZ * (float(column) - 0.5f * float(perRow - 1) + (row % 2 ? 0.5f : 0.0f)) + 1.2f * random(2)};
    copy.angle = 0.55f * random(3);
    copy.scale = 0.92f + 0.3f * (random(4) + 0.5f) * (i % 3 == 1 ? -1.0f : 1.0f) * 0.8f;
    model.copies.push_back(copy);
    const std::vector<Vec3f> walking = poseVertices("walk", model.cage.positions, 50 * random(5));
    model.shapes.push_back(poseVertices("twist", walking, 24 * random(6)));
  }
  model.view.direction = {-0.8f, -0.45f, -0.5f};
  model.view.closePoint = {0.5f, 0.55f};
  model.view.closeDistance = 0.18f;
  return model;
}

} // namespace programs
