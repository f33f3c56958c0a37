// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays in blocks with frames, compiled for one instruction set: selects the intersector by the block's kind. */

#include "interface.h"
#include "../base/block_validity.h"
#include "block_intersector1.h"
#include "block_intersectorK.h"
#include <new>

namespace embree::isa::cbvh {
/*! If a stack entry is nearer than the leaf, pushes the nearest one and stores the leaf in its place. Leaves are then
 *  visited in order of distance. */
FramedRay::Entry* FramedRay::deferToNearer(BVH4::NodeRef leaf, float entryT, Entry* stack, Entry* top) {
  Entry* nearest = nullptr;
  float least = entryT;
  for (Entry* entry = stack; entry != top; entry++) {
    float distance; // Embree stores its bits as an integer
    memcpy(&distance, &entry->dist, sizeof(float));
    if (unlikely(distance < least)) {
      least = distance;
      nearest = entry;
    }
  }
  if (likely(nearest == nullptr)) return nullptr;
  *top++ = *nearest;
  nearest->ptr = leaf;
  memcpy(&nearest->dist, &entryT, sizeof(float));
  return top;
}

__noinline void FramedRay::begin(const Ray& ray) {
  static_assert(sizeof(RayState) <= sizeof(state) && alignof(RayState) <= 16, "`state` has room for a RayState");
  (new (state) RayState(tfar))->set(ray);
  hasState = true;
}

/*! Ends with a call of the kind's intersector, which is not inlined, for a short prologue. */
template<typename RayType>
__forceinline bool FramedRay::intersectByKind(RayType& ray, IntersectContext* context, const void* prim) {
  if (unlikely(!isBlockValid(prim, FRAMED_BLOCK))) return false;
  if (unlikely(!hasState)) begin(ray);
  const Block* const block = (const Block*)prim;
  RayState& own = *(RayState*)state;
  own.entryT = entryT;
  switch (kindOf(block->info)) {
  case kindLeaf: return BlockIntersector1<LeafVisitor1>::intersect(ray, context, own, block);
  case kindVoxel: return BlockIntersector1<VoxelVisitor1>::intersect(ray, context, own, block);
  case kindGrid: return BlockIntersector1<GridVisitor1>::intersect(ray, context, own, block);
  default: return false;
  }
}

bool FramedRay::intersectBlock(RayHit& ray, IntersectContext* context, const void* block) {
  return intersectByKind(ray, context, block);
}

bool FramedRay::intersectBlock(Ray& ray, IntersectContext* context, const void* block) {
  return intersectByKind(ray, context, block);
}

float FramedRay::nearestTfar(float current) const { return ((const RayState*)state)->nearest.finalTfar(current); }

template<int K>
template<typename Rays>
__forceinline vbool<K> FramedRaysK<K>::intersectBlock(const vbool<K>& valid, Rays& rays, IntersectContext* context,
                                                      const void* prim, const vfloat<K>& entryT) {
  static_assert(sizeof(RayStates<K>) <= sizeof(state) && alignof(RayStates<K>) <= 64, "`state` has room for RayStates");
  if (unlikely(!isBlockValid(prim, FRAMED_BLOCK))) return vbool<K>(false);
  const Block* const block = (const Block*)prim;
  RayStates<K>& own = *(RayStates<K>*)state;
  if (!hasState) {
    new (state) RayStates<K>(tfar);
    own.set(rays);
    hasState = true;
  }
  own.entryT = entryT;
  switch (kindOf(block->info)) {
  case kindLeaf: return BlockIntersectorK<K, LeafVisitorK>::intersect(valid, rays, context, own, block);
  case kindVoxel: return BlockIntersectorK<K, VoxelVisitorK>::intersect(valid, rays, context, own, block);
  case kindGrid: return BlockIntersectorK<K, GridVisitorK>::intersect(valid, rays, context, own, block);
  default: return vbool<K>(false);
  }
}

template<int K>
vbool<K> FramedRaysK<K>::intersect(const vbool<K>& valid, RayHitK<K>& rays, IntersectContext* context,
                                   const void* block, const vfloat<K>& entryT) {
  return intersectBlock(valid, rays, context, block, entryT);
}

template<int K>
vbool<K> FramedRaysK<K>::intersect(const vbool<K>& valid, RayK<K>& rays, IntersectContext* context, const void* block,
                                   const vfloat<K>& entryT) {
  return intersectBlock(valid, rays, context, block, entryT);
}

template<int K>
void FramedRaysK<K>::setNearestTfar(const vbool<K>& valid, vfloat<K>& current) const {
  ((const RayStates<K>*)state)->setFinalTfar(valid, current);
}

#if defined(EMBREE_RAY_PACKETS)
template class FramedRaysK<4>;
#if defined(__AVX__)
template class FramedRaysK<8>;
#endif
#if defined(__AVX512F__)
template class FramedRaysK<16>;
#endif
#endif
} // namespace embree::isa::cbvh
