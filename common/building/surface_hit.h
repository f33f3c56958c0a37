// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "basics/vec.h"

#include <embree3/rtcore.h>

namespace cbvh {

/* Where a ray meets the surface, in the terms of the subdivision surface whatever
 * the representation: face and its (u,v) as GRID reports them. */
struct SurfaceHit
{
  float t = INFINITY; // infinite: a miss
  float u = 0, v = 0;
  unsigned face = RTC_INVALID_GEOMETRY_ID; // numbered on from copy to copy of a model
  Vec3f normal;       // geometric, not normalised, orientation of dP/du x dP/dv

  bool hit() const { return t < INFINITY; }
};

} // namespace cbvh
