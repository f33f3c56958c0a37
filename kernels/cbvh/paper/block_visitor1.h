// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Base of the visitors in grid/, leaf/ and voxel/, which intersect leaves with a single ray: reports its hits. */

#include "block_walk1.h"
#include "block_hit.h"
#include "../base/report_hit.h"

namespace embree::isa::cbvh {
typedef LeafHit<float, bool> LeafHit1;

template<typename RayType>
struct BlockVisitor1 {
  RayType& ray;
  IntersectContext* context;
  const RayState& state;
  const Block* block;
  const BlockLayout& layout;
  const LocalRay& local;
  const NodeRay& nodeRay;
  BlockTiles& tiles;
  float sBest; //!< s at which the walk ends: not before the hit that shortened it; at most 1 + slackOfS
  bool isHit;  //!< a hit in this block was accepted

  __forceinline BlockVisitor1(RayType& ray, IntersectContext* context, const RayState& state, const Block* block,
                              const BlockLayout& layout, const LocalRay& local, const NodeRay& nodeRay,
                              BlockTiles& tiles)
    : ray(ray),
      context(context),
      state(state),
      block(block),
      layout(layout),
      local(local),
      nodeRay(nodeRay),
      tiles(tiles),
      sBest(ray.tfar < state.tfar ? min(local.parameterAfter(state.rcpScale, ray.tfar), 1.0f) : 1.0f),
      isHit(false) {}

  /* Members that BlockWalk1 requires; only cLEAF overrides them. */
  typedef NodeEntries::Tile LeafTile;
  static const uint32_t passedMask = 0u;
  __forceinline bool passSubtree(bool) { return false; }
  __forceinline LeafTile& leafTile(uint32_t m) { return tiles.tile(tiles.lastLevel(), m); }

  /*! True if the segment begins (ends) inside a leaf's box, at tnear (tfar). */
  __forceinline bool startsInside(const BoxRanges<16>& ranges, uint32_t leaf) const {
    return local.startClipped && ranges.sNear[leaf] < 0.0f;
  }
  __forceinline bool endsInside(const BoxRanges<16>& ranges, uint32_t leaf) const {
    return local.endClipped && ranges.sFar[leaf] > 1.0f;
  }

  /*! Reports a hit, unless the ray's current hit takes precedence. Returns false if a mask or filter rejected it,
   *  otherwise true, so that the walk does not depend on the order of blocks. leaf: index in Morton order. */
  __forceinline bool reportHit(uint32_t leaf, const LeafHit1& at) {
    const HitSegment<float> segment = {{nodeRay.P[0], nodeRay.P[1], nodeRay.P[2]},
                                       {nodeRay.D[0], nodeRay.D[1], nodeRay.D[2]},
                                       local.t0,
                                       local.t1,
                                       local.w0,
                                       local.w1,
                                       {state.dir.x, state.dir.y, state.dir.z},
                                       state.scale,
                                       state.rcpDir2,
                                       ray.tnear(),
                                       state.tfar,
                                       state.entryT};
    const float hitT = segment.distanceAt(at.s), comparedT = segment.comparedT(hitT);
    if (!state.nearest.isBefore(comparedT, hitT, block, ray.tfar, context->scene->surfaceIDs)) {
      SurfaceHit1 hit = {0.0f, 0.0f, hitT, Vec3fa(zero)};
      if (needsHitData(ray, context, block->surface)) {
        const BlockHit<float> found = HitConverter<float, bool>(block, layout).convert(segment, leaf, at, hitT);
        hit = SurfaceHit1{found.u, found.v, found.t, Vec3fa(found.Ng.x, found.Ng.y, found.Ng.z)};
      }
      if (!report(ray, context, block->surface, block->primID, hit)) return false;
      state.nearest.set(comparedT, hitT, block, ray.tfar);
      if (!IsAnyHit<RayType>::value) ray.tfar = state.nearest.comparedT;
      isHit = true;
    }
    sBest = at.s;
    return true;
  }
};
} // namespace embree::isa::cbvh
