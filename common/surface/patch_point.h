// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Points in Embree's parameters and in those of patches, converted by PatchWalk. */

namespace programs {

/* (u,v) as Embree reports them. */
struct FacePoint {
  unsigned face;
  float u, v;
};

/* (u,v) are in [0,1]. */
struct PatchPoint {
  unsigned face, subPatch;
  double u, v;
};

} // namespace programs
