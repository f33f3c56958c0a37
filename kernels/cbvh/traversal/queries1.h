// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray and point queries of the top-level BVH4 that Embree calls for scenes with compressed geometries: one class
 * for the tree of surfaces at rest, one for the tree of moving surfaces. Leaves are blocks (base/leaf_type.h), or
 * Embree's grids for patches that are not compressed. */

#include "../embree/traversal.h"

namespace embree::isa {
/*! Queries of the tree of surfaces at rest. */
struct CompressedSubdivTraversal1 {
  static void intersect(const Accel::Intersectors* This, RayHit& ray, IntersectContext* context);
  static void occluded(const Accel::Intersectors* This, Ray& ray, IntersectContext* context);

  /*! Returns true if a call of the application's function returned true, because it changed the query. */
  static bool pointQuery(const Accel::Intersectors* This, PointQuery* query, PointQueryContext* context);
};

/*! Queries of the tree of moving surfaces. */
struct CompressedMotionTraversal1 {
  static void intersect(const Accel::Intersectors* This, RayHit& ray, IntersectContext* context);
  static void occluded(const Accel::Intersectors* This, Ray& ray, IntersectContext* context);

  /*! See CompressedSubdivTraversal1. */
  static bool pointQuery(const Accel::Intersectors* This, PointQuery* query, PointQueryContext* context);

  static __forceinline BBox3fa boundsAtAllTimes(const BVH4* bvh) {
    return merge(bvh->bounds.bounds0, bvh->bounds.bounds1);
  }

  /* For callers that have tested the ray and the bounds. */
  static void intersectTree(const BVH4* bvh, RayHit& ray, IntersectContext* context);
  static void occludedTree(const BVH4* bvh, Ray& ray, IntersectContext* context);
};
} // namespace embree::isa
