// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A closed all-quad cage from a smooth union of capsules: the surface of the voxels inside, projected onto the
 * union. It has many extraordinary vertices, of valence 3, 5 and 6, on purpose. */

#include "surface/cage.h"

#include <functional>
#include <vector>

namespace programs {

/* The hull of two balls. `smooth` is the radius of the blend with earlier capsules in world units, 0 for a crease.
 * `carve` subtracts. */
struct Capsule {
  Vec3f a, b;
  float radiusA, radiusB;
  float smooth;
  bool carve = false;
};

/* Edge length of voxels along an axis (0 to 2) at a coordinate. */
using VoxelSize = std::function<float(int axis, float coordinate)>;

/* Signed distance, negative inside. Capsules are combined in order. */
float distanceToCapsules(const std::vector<Capsule>& capsules, Vec3f p);

/* The cage is manifold. */
Cage makeImplicitCage(const std::vector<Capsule>& capsules, const VoxelSize& voxelSize);

} // namespace programs
