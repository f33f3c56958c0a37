// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Selects the intersector of a leaf of the top-level BVH by the leaf's type (base/primitive_type.h), for single
 * rays. */

#include "../base/block_validity.h"
#include "../base/primitive_type.h"
#include "../exact/intersector1.h"
#include "../exact/mesh_intersector1.h"
#if !defined(EMBREE_CBVH_NO_PAPER)
#include "../paper/framed_rays1.h"
#endif

namespace embree::isa::cbvh {
#if defined(EMBREE_CBVH_NO_PAPER)
/*! Replaces paper/framed_rays1.h in libraries without the paper's representations. */
struct FramedRay {
  __forceinline explicit FramedRay(float) {}
  static __forceinline bool isFramed(size_t) { return false; }
  __forceinline void setEntryT(float) {}
  template<typename RayType>
  __forceinline bool intersect(RayType&, IntersectContext*, const void*) {
    return false;
  }
  __forceinline float finalTfar(float tfar) const { return tfar; }
};
#endif

/*! Intersects a leaf that does not move. Returns false if it is not a block. Otherwise sets `found` to whether a
 *  hit was accepted. framed, vertRay: the ray for blocks with and without frames. For the closest hit with a
 *  framed block, the caller must first call framed.setEntryT(). */
template<typename RayType>
__forceinline bool intersectBlock(size_t type, RayType& ray, IntersectContext* context, FramedRay& framed,
                                  VertRay& vertRay, const void* prim, bool& found) {
  if (type == VERT_BLOCK) {
    found = intersectVert(ray, context, vertRay, (const VertHeader*)prim);
    return true;
  }
  if (type == MESH_BLOCK) {
    found = intersectMesh(ray, context, vertRay, prim);
    return true;
  }
  if (type != FRAMED_BLOCK) return false;
  found = framed.intersect(ray, context, prim);
  return true;
}

/*! Intersects a leaf of the tree of moving blocks. Returns true if a hit was accepted. */
template<typename RayType>
__forceinline bool intersectMovingBlock(size_t type, RayType& ray, IntersectContext* context, VertRay& vertRay,
                                        const void* prim) {
  if (unlikely(type == MOVING_MESH_BLOCK)) return intersectMovingMesh(ray, context, vertRay, prim);
  return intersectMovingVert(ray, context, vertRay, (const VertHeader*)prim);
}
} // namespace embree::isa::cbvh
