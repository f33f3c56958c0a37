// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/vec.h"

namespace cbvh {

/* How a model likes to be looked at. */
struct ViewHints
{
  Vec3f direction{-0.5f, -0.35f, -1.0f}; // from the eye to the middle of the model
  Vec3f up{0, 1, 0};
  Vec2f closePoint{0.5f, 0.4f};          // what the close view looks at, in the full view, from the upper left
  float closeDistance = 0.12f;           // from the eye, in bounding-box diagonals
};

} // namespace cbvh
