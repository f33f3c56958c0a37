// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The two names of a point of the surface. PatchWalk turns one into the other. */

namespace cbvh {

/* A point of a cage as Embree names it. */
struct FacePoint
{
  unsigned face;
  float u, v;
};

/* A point of a patch, (u,v) from 0 to 1 in it. */
struct PatchPoint
{
  unsigned face, subPatch;
  double u, v;
};

} // namespace cbvh
