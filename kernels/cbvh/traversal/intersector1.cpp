// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Single-ray queries of the tree of surfaces at rest, compiled for one instruction set: the choice of a leaf's
 * intersector by the leaf's type. */

#include "queries1.h"
#include "top_level1.h"
#include "../base/leaf_type.h"
#include "../exact/tile_intersector1.h"
#include "../paper/interface.h"

namespace embree::isa {
namespace cbvh {
/*! Of quads or of a mesh. */
template<typename RayType>
__forceinline bool intersectAnyTile(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* tile) {
  return isMeshTile(tile) ? intersectMeshTile(ray, context, vertRay, tile)
                          : intersectTile(ray, context, vertRay, (const VertHeader*)tile);
}

/*! State of a ray for the leaves of the tree of surfaces at rest. */
struct StaticRay {
  SubdivPatch1Intersector1::Precalculations grids;
  FramedRay framed;
  VertRay vert;

  /*! isFiltered: filter functions must see hits in order, see FramedRay. */
  __forceinline StaticRay(const Ray& ray, const void* bvh, bool isFiltered)
    : grids(ray, bvh),
      framed(ray.tfar, isFiltered) {}
};

/*! Leaves of the tree of surfaces at rest: blocks, and grids by Embree's intersector. Refers to the ray's state, whose
 *  address intersectors get, so that compilers keep the other members in registers. */
class StaticLeaves {
  typedef SubdivPatch1Intersector1 Grids;
  typedef TravRay<4, true> Tray;

public:
  __forceinline StaticLeaves(const Accel::Intersectors* This, IntersectContext* context, StaticRay& state)
    : This(This),
      context(context),
      state(state) {}

  /*! See traverseClosestHit1. */
  __forceinline StackEntry* intersect(RayHit& ray, const ReachedLeaf& leaf, const Tray& tray, StackEntry* stack,
                                      StackEntry* top) {
    size_t type;
    const void* const prim = leaf.ref.leaf(type);
    switch (likelyType(type)) {
    case VERT_BLOCK: intersectVert(ray, context, state.vert, (const VertHeader*)prim); return top;
    case TILE_BLOCK: intersectAnyTile(ray, context, state.vert, prim); return top;
    case MESH_BLOCK: intersectMesh(ray, context, state.vert, prim); return top;
    case FRAMED_BLOCK: return state.framed.intersect(ray, context, leaf.ref, leaf.entryT(), stack, top);
    }
    // a grid of Embree
    size_t lazyNode = 0; // must be traversed next
    Grids::intersect(This, state.grids, ray, context, (const GridSOA*)prim, type, tray, lazyNode);
    return lazyNode ? push(top, BVH4::NodeRef(lazyNode), neg_inf) : top;
  }

  /*! See traverseAnyHit1. */
  __forceinline bool isOccluded(Ray& ray, BVH4::NodeRef leaf, const Tray& tray, BVH4::NodeRef*& top) {
    size_t type;
    const void* const prim = leaf.leaf(type);
    switch (likelyType(type)) {
    case VERT_BLOCK: return intersectVert(ray, context, state.vert, (const VertHeader*)prim);
    case TILE_BLOCK: return intersectAnyTile(ray, context, state.vert, prim);
    case MESH_BLOCK: return intersectMesh(ray, context, state.vert, prim);
    case FRAMED_BLOCK: return state.framed.occluded(ray, context, prim);
    }
    // a grid of Embree
    size_t lazyNode = 0;
    if (Grids::occluded(This, state.grids, ray, context, (const GridSOA*)prim, type, tray, lazyNode)) return true;
    if (lazyNode) *top++ = BVH4::NodeRef(lazyNode);
    return false;
  }

private:
  static __forceinline BlockType likelyType(size_t type) { return BlockType(__builtin_expect(long(type), VERT_BLOCK)); }

  const Accel::Intersectors* This;
  IntersectContext* context;
  StaticRay& state;
};

/*! Blocks below wide nodes, which the builder makes for these types only. */
template<typename RayType>
class WideLeaves {
public:
  __forceinline WideLeaves(RayType& ray, IntersectContext* context) : ray(ray), context(context) {}

  /*! Returns true if a hit was accepted. */
  __forceinline bool operator()(BVH4::NodeRef leaf) {
    size_t type;
    const void* const prim = leaf.leaf(type);
    switch (BlockType(__builtin_expect(long(type), TILE_BLOCK))) {
    case TILE_BLOCK: return intersectAnyTile(ray, context, vert, prim);
    case VERT_BLOCK: return intersectVert(ray, context, vert, (const VertHeader*)prim);
    case MESH_BLOCK: return intersectMesh(ray, context, vert, prim);
    case FRAMED_BLOCK: break; // not below wide nodes
    }
    return false;
  }

private:
  RayType& ray;
  IntersectContext* context;
  VertRay vert;
};

__noinline void intersectWide(const WideNode* root, RayHit& ray, IntersectContext* context) {
  WideLeaves<RayHit> leaves(ray, context);
  traverseClosestHit<WideRay>(root, ray, leaves);
}

__noinline bool isOccludedWide(const WideNode* root, Ray& ray, IntersectContext* context) {
  WideLeaves<Ray> leaves(ray, context);
  return traverseAnyHit<WideRay>(root, ray, leaves);
}
} // namespace cbvh

/*! Root of the tree of wide nodes, or null. */
static __forceinline const WideNode* wideRoot(const BVH4* bvh) {
  const mvector<WideNode>& nodes = ((const CompressedTree*)bvh)->wide;
  return nodes.empty() ? nullptr : nodes.data();
}

void CompressedSubdivTraversal1::intersect(const Accel::Intersectors* This, RayHit& ray, IntersectContext* context) {
  const BVH4* bvh = (const BVH4*)This->ptr;
  if (const WideNode* root = wideRoot(bvh)) return cbvh::intersectWide(root, ray, context);
  if (bvh->root == BVH4::emptyNode || unlikely(!cbvh::isValidRay(ray))) return;
  const bool isFiltered = context->hasContextFilter() || context->scene->hasGeometryFilterFunction();
  cbvh::StaticRay state(ray, bvh, isFiltered);
  cbvh::StaticLeaves leaves(This, context, state);
  cbvh::traverseClosestHit1(bvh->root, cbvh::StaticNodes(), ray, leaves);
  ray.tfar = state.framed.finalTfar(ray.tfar);
}

void CompressedSubdivTraversal1::occluded(const Accel::Intersectors* This, Ray& ray, IntersectContext* context) {
  const BVH4* bvh = (const BVH4*)This->ptr;
  if (const WideNode* root = wideRoot(bvh)) {
    if (cbvh::isOccludedWide(root, ray, context)) ray.tfar = neg_inf;
    return;
  }
  // tfar < 0: Embree's mark of an any-hit ray that has found a hit
  if (bvh->root == BVH4::emptyNode || unlikely(ray.tfar < 0.0f || !cbvh::isValidRay(ray))) return;
  cbvh::StaticRay state(ray, bvh, false);
  cbvh::StaticLeaves leaves(This, context, state);
  if (cbvh::traverseAnyHit1(bvh->root, cbvh::StaticNodes(), ray, leaves)) ray.tfar = neg_inf;
}

DEFINE_INTERSECTOR1(BVH4CompressedSubdivIntersector1, CompressedSubdivTraversal1);
} // namespace embree::isa
