// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/vec.h"

namespace programs {

struct Ray {
  Vec3f origin;
  float tnear = 0.0f;
  Vec3f direction; // unit length unless documented otherwise, so that t is a distance
  float tfar = INFINITY;
  float time = 0.0f; // in [0,1]
};

} // namespace programs
