// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A closed all-quad cage from a smooth union of capsules: the surface of the voxels inside, projected onto the union.
 * Voxel surfaces have extraordinary vertices of valence 3, 5 and 6 wherever the surface is not parallel to an axis,
 * which is the purpose of this method. */

#include "surface/cage.h"

#include <functional>
#include <vector>

namespace cbvh {

/* The hull of two balls. `smooth` is the radius, in world units, of the blend with earlier capsules; 0 makes a crease.
 * If `carve` is set, the capsule is subtracted. */
struct Capsule
{
  Vec3f a, b;
  float radiusA, radiusB;
  float smooth;
  bool carve = false;
};

/* Returns the edge length of voxels along an axis (0 to 2) at a coordinate on it. */
using VoxelSize = std::function<float(int axis, float coordinate)>;

/* Returns the signed distance, negative inside. Capsules are combined in order. */
float distanceToCapsules(const std::vector<Capsule>& capsules, Vec3f p);

/* Returns the cage. It is manifold: voxels that share only an edge or a corner are joined by filling. */
Cage makeImplicitCage(const std::vector<Capsule>& capsules, const VoxelSize& voxelSize);

} // namespace cbvh
