// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/vec.h"

namespace cbvh {

struct Ray
{
  Vec3f origin;
  float tnear = 0.0f;
  Vec3f direction; // of length 1 unless said otherwise, so t is a distance
  float tfar = INFINITY;
  float time = 0.0f; // while the shutter is open, from 0 to 1
};

} // namespace cbvh
