// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays in blocks with frames, for traversal. This folder, with the paper's representations, has one entry per user;
 * other folders include none of its other headers:
 *
 *   entry         used by                    declares                               EMBREE_CBVH_NO_PAPER
 *   interface.h   traversal                  FramedRay, FramedRaysK: the blocks'    no block is ever hit
 *                                            rays, compiled by rays.cpp
 *   writer.h      building/cage_source.h     FramedWriter: patches to blocks        building/no_framed_writer.h
 *   block.h       blocks, files, backend     the bytes of a block                   the same: files may have blocks
 *   node_cache.h  traversal/thread_cache.cpp the cache of decoded nodes             no cache
 */

#include "../embree/traversal.h"

namespace embree::isa::cbvh {
#if defined(EMBREE_CBVH_NO_PAPER)
struct FramedRay {
  __forceinline FramedRay(float, bool) {}
  template<typename Entry>
  __forceinline Entry* intersect(RayHit&, IntersectContext*, BVH4::NodeRef, float, Entry*, Entry* top) {
    return top;
  }
  __forceinline bool occluded(Ray&, IntersectContext*, const void*) { return false; }
  __forceinline float finalTfar(float tfar) const { return tfar; }
};

template<int K>
struct FramedRaysK {
  __forceinline explicit FramedRaysK(const vfloat<K>&) {}
  template<typename Rays>
  __forceinline vbool<K> intersect(const vbool<K>&, Rays&, IntersectContext*, const void*, const vfloat<K>&) {
    return vbool<K>(false);
  }
  __forceinline void setFinalTfar(const vbool<K>&, vfloat<K>&) const {}
};
#else

/*! A ray, for all blocks with frames that it visits. The first one sets its state. */
class FramedRay {
  typedef StackItemT<BVH4::NodeRef> Entry;

public:
  /*! tfar: before any hit. isFiltered: filter functions must see hits in the order of distance. */
  __forceinline FramedRay(float tfar, bool isFiltered) : tfar(tfar), isFiltered(isFiltered), hasState(false) {}

  /*! Finds the closest hit in a leaf. entryT: distance to the entry into its bounds. stack, top: of the traversal. If
   *  the ray is filtered and a stack entry is nearer, exchanges them instead: Embree sorts only the children of one
   *  node. Returns the new top of the stack. A damaged block has no hits. */
  __forceinline Entry* intersect(RayHit& ray, IntersectContext* context, BVH4::NodeRef leaf, float entryT, Entry* stack,
                                 Entry* top) {
    if (unlikely(isFiltered))
      if (Entry* const deferred = deferToNearer(leaf, entryT, stack, top)) return deferred;
    this->entryT = entryT;
    size_t type;
    intersectBlock(ray, context, leaf.leaf(type));
    return top;
  }

  /*! Returns true if a hit was accepted. */
  __forceinline bool occluded(Ray& ray, IntersectContext* context, const void* block) {
    return intersectBlock(ray, context, block);
  }

  /*! Required after the traversal for closest hits: returns the ray's final tfar, see NearestHit. */
  __forceinline float finalTfar(float current) const { return likely(!hasState) ? current : nearestTfar(current); }

private:
  float nearestTfar(float current) const;
  bool intersectBlock(RayHit& ray, IntersectContext* context, const void* block);
  bool intersectBlock(Ray& ray, IntersectContext* context, const void* block);
  template<typename RayType>
  bool intersectByKind(RayType& ray, IntersectContext* context, const void* block);
  void begin(const Ray& ray);

  /*! Returns null, or the new top of the stack. */
  static Entry* deferToNearer(BVH4::NodeRef leaf, float entryT, Entry* stack, Entry* top);

  const float tfar;
  float entryT = neg_inf;
  const bool isFiltered;
  bool hasState;
  alignas(16) char state[96]; //!< RayState
};

/*! FramedRay for packets. */
template<int K>
class FramedRaysK {
public:
  __forceinline explicit FramedRaysK(const vfloat<K>& tfar) : tfar(tfar), hasState(false) {}

  /*! Returns the rays that accepted a hit. entryT: see FramedRay. */
  vbool<K> intersect(const vbool<K>& valid, RayHitK<K>& rays, IntersectContext* context, const void* block,
                     const vfloat<K>& entryT);
  vbool<K> intersect(const vbool<K>& valid, RayK<K>& rays, IntersectContext* context, const void* block,
                     const vfloat<K>& entryT);

  /*! Required after the traversal for closest hits: sets the final tfar. */
  __forceinline void setFinalTfar(const vbool<K>& valid, vfloat<K>& current) const {
    if (unlikely(hasState)) setNearestTfar(valid, current);
  }

private:
  void setNearestTfar(const vbool<K>& valid, vfloat<K>& current) const;
  template<typename Rays>
  vbool<K> intersectBlock(const vbool<K>& valid, Rays& rays, IntersectContext* context, const void* block,
                          const vfloat<K>& entryT);

  const vfloat<K> tfar;
  bool hasState;
  alignas(64) char state[64 * K + 64]; //!< RayStates<K>
};
#endif
} // namespace embree::isa::cbvh
