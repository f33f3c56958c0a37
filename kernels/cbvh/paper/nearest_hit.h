// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Makes hits in blocks with frames independent of the order in which blocks are visited. */

#include "block.h"
#include "../base/surface_ids.h"
#include "../embree/simd.h"

namespace embree::isa::cbvh {
using namespace embree::cbvh;

/*! The nearest hit of a ray in blocks with frames. Blocks extend slightly past their top-level bounds
 *  (block_bounds.h), so a hit can lie before the ray enters these bounds, and traversal may already have culled
 *  the block. Hits are therefore compared by the greater of two distances: of the hit, and of the entry into the
 *  bounds. During the traversal, this is the ray's tfar. Ties are resolved by the distances of hits, then by
 *  geomID, primID and the position of the block. Distances are along the application's ray. */
struct NearestHit {
  float comparedT = pos_inf; //!< distance by which hits are compared
  float hitT = pos_inf;      //!< distance of the hit itself
  const Block* block = nullptr;

  /*! True if the ray's current hit, at tfar, takes precedence over another one. The current hit may be in any
   *  primitive; the other one is in a block with a frame. ids: of the scene. */
  __forceinline bool isBefore(float otherComparedT, float otherHitT, const Block* other, float tfar,
                              const SurfaceIDs& ids) const {
    return likely(otherComparedT < tfar) ? false
                                         : otherComparedT > tfar || otherHitT > hitT ||
                                               (otherHitT == hitT && block && !hasPrecedence(other, block, ids));
  }

  /*! Stores an accepted hit. tfar: below hitT if a filter decreased it. The hit then counts as at tfar. */
  __forceinline void set(float comparedT, float hitT, const Block* block, float tfar) {
    this->comparedT = tfar < hitT ? tfar : comparedT;
    this->hitT = min(tfar, hitT);
    this->block = block;
  }

  /*! Returns the ray's final tfar: hitT, if this is the ray's nearest hit. */
  __forceinline float finalTfar(float tfar) const { return block && tfar == comparedT ? hitT : tfar; }

private:
  /*! True if a comes before b; false if both are the same block. */
  static bool hasPrecedence(const Block* a, const Block* b, const SurfaceIDs& ids) {
    if (a->surface != b->surface) return ids[a->surface] < ids[b->surface];
    if (a->primID != b->primID) return a->primID < b->primID;
    return a->tiling != b->tiling ? a->tiling < b->tiling : a->info < b->info;
  }
};
} // namespace embree::isa::cbvh
