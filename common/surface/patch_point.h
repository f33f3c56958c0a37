// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Points of the surface in Embree's parameters and in those of patches. PatchWalk converts between them. */

namespace cbvh {

/* A point of a face with Embree's (u,v). */
struct FacePoint
{
  unsigned face;
  float u, v;
};

/* A point of a patch, (u,v) in [0,1]. */
struct PatchPoint
{
  unsigned face, subPatch;
  double u, v;
};

} // namespace cbvh
