// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* block_visitor1.h for packets. */

#include "block_walkK.h"
#include "block_hit.h"
#include "../base/report_hit.h"
#include <tuple>

namespace embree::isa::cbvh {
template<int K> using LeafHits = LeafHit<vfloat<K>, vbool<K>>;

template<int K, typename Rays>
struct BlockVisitorK {
  typedef NodeEntries::Tile LeafTile;

  Rays& rays;
  IntersectContext* context;
  const RayStates<K>& state;
  const Block* block;
  const BlockLayout& layout;
  const NodeRays<K>& nodeRays;
  BlockTiles& tiles;
  vfloat<K> sBest;     //!< see BlockVisitor1
  vbool<K> activeRays; //!< rays that continue the walk; in any-hit queries, rays without an accepted hit
  vbool<K> isHit;      //!< rays with an accepted hit in this block

  __forceinline BlockVisitorK(Rays& rays, IntersectContext* context, const RayStates<K>& state, const Block* block,
                              const BlockLayout& layout, const NodeRays<K>& nodeRays, BlockTiles& tiles,
                              const vbool<K>& valid)
    : rays(rays),
      context(context),
      state(state),
      block(block),
      layout(layout),
      nodeRays(nodeRays),
      tiles(tiles),
      sBest(1.0f),
      activeRays(valid),
      isHit(false) {
    const vbool<K> nearer = valid & (rays.tfar < state.tfar);
    if (any(nearer))
      sBest = select(nearer, min(nodeRays.parameterAfter(state.rcpScale, rays.tfar), vfloat<K>(1.0f)), sBest);
  }

  /* Members that BlockWalkK requires; only cLEAF overrides them. */
  static const bool tracksPassedBoxes = false;
  __forceinline vbool<K> needsPassedBoxes() const { return vbool<K>(false); }
  __forceinline void passBoxes(const vbool<K>&, const vbool<K>&) {}
  __forceinline LeafTile& leafTile(uint32_t m) { return tiles.tile(tiles.lastLevel(), m); }

  /* As in BlockVisitor1. */
  __forceinline vbool<K> startsInside(const BoxRangesK<K>& box) const {
    return nodeRays.startClipped & (box.sNear < vfloat<K>(zero));
  }
  __forceinline vbool<K> endsInside(const BoxRangesK<K>& box) const {
    return nodeRays.endClipped & (box.sFar > vfloat<K>(1.0f));
  }

  /*! As BlockVisitor1::reportHit, for the rays in `lanes`. */
  __forceinline vbool<K> reportHits(const vbool<K>& lanes, uint32_t leaf, const LeafHits<K>& hits) {
    const HitSegment<vfloat<K>> segment = segments();
    const vfloat<K> hitT = segment.distanceAt(hits.s), comparedT = segment.comparedT(hitT);
    vbool<K> counts = lanes;
    const vbool<K> front = lanes & precedes(lanes, comparedT, hitT);
    if (any(front)) {
      const vbool<K> accepted =
          front & report(rays, front, context, block->surface, block->primID, [&] {
            const BlockHit<vfloat<K>> hit =
                HitConverter<vfloat<K>, vbool<K>>(block, layout).convert(segment, leaf, hits, hitT);
            return std::make_tuple(hit.u, hit.v, hit.t, Vec3vf<K>(hit.Ng));
          });
      for (uint32_t rest = uint32_t(movemask(accepted)); rest; rest &= rest - 1) {
        const uint32_t k = uint32_t(bsf(rest));
        state.nearest[k].set(comparedT[k], hitT[k], block, rays.tfar[k]);
      }
      if (!IsAnyHit<Rays>::value) rays.tfar = select(andn(accepted, rays.tfar < hitT), comparedT, rays.tfar);
      accept(accepted);
      counts = andn(lanes, andn(front, accepted));
    }
    sBest = select(counts, hits.s, sBest);
    return counts;
  }

  /*! Records rays whose hit was accepted. reportHits() calls it; visitors that report hits themselves must call
   *  it. */
  __forceinline void accept(const vbool<K>& accepted) {
    isHit |= accepted;
    if (IsAnyHit<Rays>::value) activeRays = andn(activeRays, accepted);
  }

private:
  __forceinline HitSegment<vfloat<K>> segments() const {
    const NodeRays<K>& n = nodeRays;
    return HitSegment<vfloat<K>>{{n.P[0], n.P[1], n.P[2]},
                                 {n.D[0], n.D[1], n.D[2]},
                                 n.t0,
                                 n.t1,
                                 n.w0,
                                 n.w1,
                                 {state.dir.x, state.dir.y, state.dir.z},
                                 state.scale,
                                 state.rcpDir2,
                                 rays.tnear(),
                                 state.tfar,
                                 state.entryT};
  }

  /*! Rays of `lanes` whose hits take precedence over their current ones. Other rays are undefined. */
  __forceinline vbool<K> precedes(const vbool<K>& lanes, const vfloat<K>& comparedT, const vfloat<K>& hitT) const {
    vbool<K> front = comparedT < rays.tfar;
    for (uint32_t rest = uint32_t(movemask(lanes & (comparedT == rays.tfar))); unlikely(rest != 0u); rest &= rest - 1) {
      const uint32_t k = uint32_t(bsf(rest));
      const SurfaceIDs& ids = context->scene->surfaceIDs;
      if (!state.nearest[k].isBefore(comparedT[k], hitT[k], block, rays.tfar[k], ids)) set(front, k);
    }
    return front;
  }
};
} // namespace embree::isa::cbvh
