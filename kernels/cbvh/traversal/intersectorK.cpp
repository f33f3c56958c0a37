// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Intersectors of packets and streams, instantiated for one instruction set, with the same hits as single rays. Rays
 * traverse the top-level BVH and blocks together if the context is coherent, otherwise one by one, and always one by
 * one through moving blocks, because their times differ. */

#include "queries1.h"
#include "packet_traversal.h"
#include "../base/leaf_type.h"
#include "../exact/intersectorK.h"
#include "../exact/mesh_intersectorK.h"
#include "../paper/interface.h"

namespace embree::isa {
/*! The LeafIntersector of PacketTraversal: blocks, and Embree's grids for patches that are not compressed. */
template<int K, typename Rays>
class SubdivLeafIntersectorK {
  typedef SubdivPatch1IntersectorK<K> Grids;
  typedef TravRayK<K, true> Tray;
  static const bool isAnyHit = cbvh::IsAnyHit<Rays>::value;

public:
  vfloat<K> tfar; //!< see PacketTraversal

  __forceinline SubdivLeafIntersectorK(const vbool<K>& valid, const Accel::Intersectors* This, Rays& rays,
                                       IntersectContext* context)
    : tfar(rays.tfar),
      This(This),
      rays(rays),
      context(context),
      grids(valid, rays),
      framed(rays.tfar) {}

  __forceinline void intersect(const vbool<K>& valid, BVH4::NodeRef leaf, const vfloat<K>& entryT, const Tray& tray,
                               size_t& lazyNode) {
    size_t type;
    const void* prim = leaf.leaf(type);
    if (likely(cbvh::isBlock(type))) updateTfar(intersectBlock(valid, cbvh::BlockType(type), prim, entryT));
    else updateTfar(intersectGrid(valid, rays, (const GridSOA*)prim, type, tray, lazyNode));
  }

  /*! Sets the rays' final tfar, see NearestHit. Call it after the traversal. */
  __forceinline void finish(const vbool<K>& valid) {
    if (!isAnyHit) framed.setFinalTfar(valid, rays.tfar);
  }

private:
  /*! Updates tfar. hit: rays that accepted a hit. */
  __forceinline void updateTfar(const vbool<K>& hit) {
    tfar = isAnyHit ? select(hit, vfloat<K>(neg_inf), tfar) : vfloat<K>(rays.tfar);
  }

  /* Closest hits, then any hit, in one of Embree's grids. Return the rays that may have accepted a hit. */
  vbool<K> intersectGrid(const vbool<K>& valid, RayHitK<K>& rays, const GridSOA* prim, size_t type, const Tray& tray,
                         size_t& lazyNode) {
    Grids::intersect(valid, This, grids, rays, context, prim, type, tray, lazyNode);
    return valid;
  }
  vbool<K> intersectGrid(const vbool<K>& valid, RayK<K>& rays, const GridSOA* prim, size_t type, const Tray& tray,
                         size_t& lazyNode) {
    return Grids::occluded(valid, This, grids, rays, context, prim, type, tray, lazyNode) & valid;
  }

  /*! Returns the rays that accepted a hit in a block. */
  __forceinline vbool<K> intersectBlock(const vbool<K>& valid, cbvh::BlockType type, const void* prim,
                                        const vfloat<K>& entryT) {
    using namespace cbvh;
    switch (type) {
    case TILE_BLOCK:
      if (isMeshTile(prim)) return MeshIntersectorK<K, Rays>::intersectTile(valid, rays, context, vert, prim);
      [[fallthrough]]; // tiles of quads are decoded as blocks
    case VERT_BLOCK: return VertIntersectorK<K, Rays>::intersect(valid, rays, context, vert, (const VertHeader*)prim);
    case MESH_BLOCK: return MeshIntersectorK<K, Rays>::intersect(valid, rays, context, vert, prim);
    case FRAMED_BLOCK: return framed.intersect(valid, rays, context, prim, entryT);
    }
    return vbool<K>(false);
  }

  const Accel::Intersectors* This;
  Rays& rays;
  IntersectContext* context;
  typename Grids::Precalculations grids;
  cbvh::FramedRaysK<K> framed;
  cbvh::VertRays<K> vert;
};

/*! Copies ray k of a packet. Composes origin and direction in registers: traversal loads them as vectors, which
 *  would wait for stores of the components. */
template<int K>
__forceinline void setRay(Ray& ray, const RayK<K>& rays, size_t k) {
  ray.org = Vec3ff(rays.org.x[k], rays.org.y[k], rays.org.z[k], rays.tnear()[k]);
  ray.dir = Vec3ff(rays.dir.x[k], rays.dir.y[k], rays.dir.z[k], rays.time()[k]);
  ray.tfar = rays.tfar[k];
  ray.mask = rays.mask[k];
  ray.id = rays.id[k];
  ray.flags = rays.flags[k];
}

/*! Calls intersect(ray) or occluded(ray) for each ray of a packet in `mask`, and copies the results back. */
template<int K, typename Intersect>
__forceinline void traceOneByOne(uint32_t mask, RayHitK<K>& rays, const Intersect& intersect) {
  for (; mask; mask &= mask - 1) {
    const size_t k = bsf(mask);
    RayHit ray;
    setRay(ray, rays, k);
    ray.Ng = Vec3f(rays.Ng.x[k], rays.Ng.y[k], rays.Ng.z[k]);
    ray.u = rays.u[k];
    ray.v = rays.v[k];
    ray.primID = rays.primID[k];
    ray.geomID = rays.geomID[k];
    instance_id_stack::copy_VU<K>(rays.instID, ray.instID, k);
    intersect(ray);
    rays.tfar[k] = ray.tfar;
    rays.Ng.x[k] = ray.Ng.x;
    rays.Ng.y[k] = ray.Ng.y;
    rays.Ng.z[k] = ray.Ng.z;
    rays.u[k] = ray.u;
    rays.v[k] = ray.v;
    rays.primID[k] = ray.primID;
    rays.geomID[k] = ray.geomID;
    instance_id_stack::copy_UV<K>(ray.instID, rays.instID, k);
  }
}
template<int K, typename Occluded>
__forceinline void traceOneByOne(uint32_t mask, RayK<K>& rays, const Occluded& occluded) {
  for (; mask; mask &= mask - 1) {
    const size_t k = bsf(mask);
    Ray ray;
    setRay(ray, rays, k);
    occluded(ray);
    rays.tfar[k] = ray.tfar;
  }
}

/*! Active rays for which isValidRay() is true. mask: Embree's, -1 for active rays. */
template<int K>
__forceinline vbool<K> validRays(const vint<K>& mask, const RayK<K>& rays) {
  return (mask == vint<K>(-1)) & cbvh::isValidRay(rays);
}

/*! Packets through the tree of moving blocks. */
template<int K>
struct CompressedMotionIntersectorK {
  static void intersect(vint<K>* mask, Accel::Intersectors* This, RayHitK<K>& rays, IntersectContext* context) {
    const BVH4* bvh = (const BVH4*)This->ptr;
    traceOneByOne<K>(raysToTrace(*mask, bvh, rays), rays,
                     [&](RayHit& ray) { CompressedMotionTraversal1::intersectTree(bvh, ray, context); });
  }
  static void occluded(vint<K>* mask, Accel::Intersectors* This, RayK<K>& rays, IntersectContext* context) {
    const BVH4* bvh = (const BVH4*)This->ptr;
    // Embree marks any-hit rays with a hit by a negative tfar
    const uint32_t occludedRays = uint32_t(movemask(rays.tfar < vfloat<K>(zero)));
    traceOneByOne<K>(raysToTrace(*mask, bvh, rays) & ~occludedRays, rays,
                     [&](Ray& ray) { CompressedMotionTraversal1::occludedTree(bvh, ray, context); });
  }

private:
  static __forceinline uint32_t raysToTrace(const vint<K>& mask, const BVH4* bvh, const RayK<K>& rays) {
    const vbool<K> valid = validRays<K>(mask, rays);
    return none(valid) ? 0
                       : uint32_t(movemask(
                             valid & cbvh::mayIntersect(rays, CompressedMotionTraversal1::boundsAtAllTimes(bvh))));
  }
};

/*! Packets through the tree of surfaces at rest. */
template<int K>
struct CompressedSubdivIntersectorK {
  static void intersect(vint<K>* mask, Accel::Intersectors* This, RayHitK<K>& rays, IntersectContext* context) {
    const vbool<K> valid = validRays<K>(*mask, rays);
    traceOneByOne<K>(tracePacket(valid, This, rays, context).separate, rays,
                     [&](RayHit& ray) { CompressedSubdivTraversal1::intersect(This, ray, context); });
  }

  static void occluded(vint<K>* mask, Accel::Intersectors* This, RayK<K>& rays, IntersectContext* context) {
    const vbool<K> valid = validRays<K>(*mask, rays) & (rays.tfar >= vfloat<K>(zero));
    const PacketResult result = tracePacket(valid, This, rays, context);
    traceOneByOne<K>(result.separate, rays,
                     [&](Ray& ray) { CompressedSubdivTraversal1::occluded(This, ray, context); });
    if (any(result.occludedRays)) vfloat<K>::store(result.occludedRays, &rays.tfar, vfloat<K>(neg_inf));
  }

private:
  struct PacketResult {
    uint32_t separate;     //!< rays that the caller must trace one by one
    vbool<K> occludedRays; //!< any-hit rays with a hit
  };

  /*! If the context is coherent, traces rays with the same signs of the direction together. */
  template<typename Rays>
  static __noinline PacketResult tracePacket(const vbool<K>& valid, const Accel::Intersectors* This, Rays& rays,
                                             IntersectContext* context) {
    PacketResult result = {uint32_t(movemask(valid)), vbool<K>(false)};
    const BVH4::NodeRef root = ((const BVH4*)This->ptr)->root;
    if (!context->isCoherent() || root == BVH4::emptyNode) return result;
    SubdivLeafIntersectorK<K, Rays> leaves(valid, This, rays, context);
    cbvh::TopLevelRays<K> tray(valid, rays);
    uint32_t negativeRays[3], separate = 0;
    for (int axis = 0; axis < 3; axis++) negativeRays[axis] = uint32_t(movemask(tray.rdir[axis] < vfloat<K>(zero)));
    for (uint32_t rest = result.separate; rest;) {
      const uint32_t k = uint32_t(bsf(rest));
      uint32_t same = rest;
      for (int axis = 0; axis < 3; axis++)
        same &= (negativeRays[axis] >> k) & 1u ? negativeRays[axis] : ~negativeRays[axis];
      rest &= ~same;
      // two rays gain too little from a common traversal
      if (popcnt(same) <= 2) separate |= same;
      else
        cbvh::PacketTraversal<K, SubdivLeafIntersectorK<K, Rays>>::run(vbool<K>(int(same)), k, root, rays, tray,
                                                                       leaves);
    }
    leaves.finish(valid);
    result.separate = separate;
    result.occludedRays = valid & (leaves.tfar == vfloat<K>(neg_inf));
    return result;
  }
};

#if defined(EMBREE_RAY_PACKETS)
DEFINE_INTERSECTOR4(BVH4CompressedSubdivIntersector4, CompressedSubdivIntersectorK<4>);
DEFINE_INTERSECTOR4(BVH4CompressedMotionIntersector4, CompressedMotionIntersectorK<4>);
#if defined(__AVX__)
DEFINE_INTERSECTOR8(BVH4CompressedSubdivIntersector8, CompressedSubdivIntersectorK<8>);
DEFINE_INTERSECTOR8(BVH4CompressedMotionIntersector8, CompressedMotionIntersectorK<8>);
#endif
#if defined(__AVX512F__)
DEFINE_INTERSECTOR16(BVH4CompressedSubdivIntersector16, CompressedSubdivIntersectorK<16>);
DEFINE_INTERSECTOR16(BVH4CompressedMotionIntersector16, CompressedMotionIntersectorK<16>);
#endif
// Embree's fallback for streams passes packets
DEFINE_INTERSECTORN(BVH4CompressedSubdivIntersectorN, BVHNIntersectorStreamPacketFallback<4>);
DEFINE_INTERSECTORN(BVH4CompressedMotionIntersectorN, BVHNIntersectorStreamPacketFallback<4>);
#endif
} // namespace embree::isa
