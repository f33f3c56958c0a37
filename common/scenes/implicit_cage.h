// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A closed all-quad cage from a smooth union of capsules: the surface of the voxels
 * inside it, moved onto it. Voxel surfaces bring extraordinary vertices of valence 3
 * and 5 to 6 everywhere that the surface is not parallel to an axis, which is what
 * this is good for. */

#include "surface/cage.h"

#include <functional>
#include <vector>

namespace cbvh {

/* The hull of two balls; smooth says how softly it joins what is there already
 * (world units, 0: a crease). carve: taken away instead. */
struct Capsule
{
  Vec3f a, b;
  float radiusA, radiusB;
  float smooth;
  bool carve = false;
};

/* Edge length of voxels along an axis (0 to 2) at a coordinate on it. */
using VoxelSize = std::function<float(int axis, float coordinate)>;

/* Signed distance, negative inside, in the order given. */
float distanceToCapsules(const std::vector<Capsule>& capsules, Vec3f p);

/* Voxels that meet in an edge or corner only are joined by
 * filling, so the result is manifold. */
Cage makeImplicitCage(const std::vector<Capsule>& capsules, const VoxelSize& voxelSize);

} // namespace cbvh
