// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/vec.h"

#include <embree3/rtcore.h>

namespace programs {

/* A hit of any representation, with face and (u,v) as GRID reports them. */
struct SurfaceHit {
  float t = INFINITY; // infinity for a miss
  float u = 0, v = 0;
  unsigned face = RTC_INVALID_GEOMETRY_ID; // numbered consecutively over the copies of a model
  Vec3f normal;                            // geometric, not normalized, in the direction of dP/du x dP/dv

  bool hit() const { return t < INFINITY; }
};

} // namespace programs
