// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* block_intersector1.h for packets. */

#include "voxel/visitorK.h"
#include "leaf/visitorK.h"
#include "grid/visitorK.h"

namespace embree::isa::cbvh {
template<int K, template<int, typename> class Visitor>
struct BlockIntersectorK {
  /*! Returns the rays that accepted a hit. */
  template<typename Rays>
  static __noinline vbool<K> intersect(const vbool<K>& valid, Rays& rays, IntersectContext* context,
                                       const RayStates<K>& state, const Block* block) {
    NodeRays<K> nodeRays;
    const vbool<K> active = nodeRays.init(state, block, rays.tfar, valid);
    if (none(active)) return active;
    typedef Visitor<K, Rays> BlockVisitor;
    const BlockLayout layout = blockLayout(BlockVisitor::kind, block->height());
    BlockTiles tiles(block, layout);
    BlockVisitor visitor(rays, context, state, block, layout, nodeRays, tiles, active);
    BlockWalkK<K, BlockVisitor>(nodeRays, tiles, visitor).run(active);
    return visitor.isHit;
  }
};
} // namespace embree::isa::cbvh
