// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/vec.h"

namespace programs {

struct ViewHints {
  Vec3f direction{-0.5f, -0.35f, -1.0f}; // from the eye to the center of the model
  Vec3f up{0, 1, 0};
  Vec2f closePoint{0.5f, 0.4f}; // target of the close view in the full view, from the upper left
  float closeDistance = 0.12f;  // from eye to target, in bounding-box diagonals
};

} // namespace programs
