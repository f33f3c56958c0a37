// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A displaced subdivision surface and how it likes to be looked at. */

#include "cage.h"
#include "displacement.h"

#include <memory>
#include <string>

namespace cbvh {

struct ViewHints
{
  Vec3f direction{-0.5f, -0.35f, -1.0f}; // from the eye to the middle of the model
  Vec3f up{0, 1, 0};
  Vec2f closePoint{0.5f, 0.4f};          // what the close view looks at, in the full view, from the upper left
  float closeDistance = 0.12f;           // from the eye, in bounding-box diagonals
};

struct Model
{
  std::string name;
  Cage cage;
  std::shared_ptr<const Displacement> displacement; // none: the limit surface itself
  ViewHints view;
};

} // namespace cbvh
