// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Packets and streams, instantiated for one ISA. Rays go down the top-level BVH together, by Embree's own
 * traversal, and together through blocks with frames. Hits are those of single rays. */

#include "../../bvh/bvh_intersector_hybrid.cpp"
#include "../../bvh/bvh_intersector_stream.h"
#include "block_intersectorK.h"
#include "vert_intersectorK.h"
#include "../codec/primitive_type.h"

namespace embree
{
  namespace isa
  {
    /*! BVH_AN1 by another name, negative as Embree takes what is more for larger nodes. Of that name Embree traces
     *  packets that are said to be coherent by their frustum, without a box for each ray: so rays come to blocks
     *  whose bounds they miss, and hit there what single rays do not (build/block_bounds.h). */
    static const int nodesOfPackets = int(unsigned(BVH_AN1) | 0x80000000u);

    template<int N>
    struct BVHNNodeIntersector1<N,nodesOfPackets,true> : public BVHNNodeIntersector1<N,BVH_AN1,true> {};
    template<int N, int K>
    struct BVHNNodeIntersectorK<N,K,nodesOfPackets,true> : public BVHNNodeIntersectorK<N,K,BVH_AN1,true> {};

    /*! blocks, and GRID's own leaves where a face is not compressed */
    template<int K>
    struct CompressedSubdivIntersectorK
    {
      typedef void Primitive;
      typedef SubdivPatch1IntersectorK<K> Grids;

      struct Precalculations : public Grids::Precalculations
      {
        __forceinline Precalculations (const vbool<K>& valid, RayK<K>& rays)
          : Grids::Precalculations(valid,rays) {}

        cbvh::RaysPrecalculations<K> block;
        cbvh::VertIntersectorK<K> vert;
      };

      template<bool robust>
      static __forceinline void intersect (const vbool<K>& valid, const Accel::Intersectors* This, Precalculations& pre, RayHitK<K>& rays, IntersectContext* context,
                                           const Primitive* prim, size_t type, const TravRayK<K,robust>& tray, size_t& lazyNode)
      {
        if (unlikely(!isBlock(type))) Grids::intersect(valid,This,pre,rays,context,(const GridSOA*)prim,type,tray,lazyNode);
        else intersectBlock(valid,pre,rays,context,type,prim);
      }

      template<bool robust>
      static __forceinline vbool<K> occluded (const vbool<K>& valid, const Accel::Intersectors* This, Precalculations& pre, RayK<K>& rays, IntersectContext* context,
                                              const Primitive* prim, size_t type, const TravRayK<K,robust>& tray, size_t& lazyNode)
      {
        if (unlikely(!isBlock(type))) return Grids::occluded(valid,This,pre,rays,context,(const GridSOA*)prim,type,tray,lazyNode);
        return intersectBlock(valid,pre,rays,context,type,prim);
      }

      template<int N, bool robust>
      static __forceinline void intersect (const Accel::Intersectors* This, Precalculations& pre, RayHitK<K>& rays, size_t k, IntersectContext* context,
                                           const Primitive* prim, size_t type, const TravRay<N,robust>& tray, size_t& lazyNode)
      {
        if (unlikely(!isBlock(type))) Grids::intersect(This,pre,rays,k,context,(const GridSOA*)prim,type,tray,lazyNode);
        else intersectBlock(laneOf(k),pre,rays,context,type,prim);
      }

      template<int N, bool robust>
      static __forceinline bool occluded (const Accel::Intersectors* This, Precalculations& pre, RayK<K>& rays, size_t k, IntersectContext* context,
                                          const Primitive* prim, size_t type, const TravRay<N,robust>& tray, size_t& lazyNode)
      {
        if (unlikely(!isBlock(type))) return Grids::occluded(This,pre,rays,k,context,(const GridSOA*)prim,type,tray,lazyNode);
        return any(intersectBlock(laneOf(k),pre,rays,context,type,prim));
      }

    private:
      static __forceinline bool isBlock (size_t type) { return type >= cbvh::FIRST_BLOCK; }
      static __forceinline vbool<K> laneOf (size_t k) { return vbool<K>(int(1u << k)); }

      /*! which rays accepted a hit */
      template<typename Rays>
      static __noinline vbool<K> intersectBlock (const vbool<K>& handed, Precalculations& pre, Rays& rays, IntersectContext* context, size_t type, const void* prim)
      {
        using namespace cbvh;
        const vbool<K> valid = handed & (rays.tnear() <= rays.tfar); // Embree hands over what has no range, too
        if (type == blockType(kindVert)) return vbool<K>(int(pre.vert.intersect(uint32_t(movemask(valid)),rays,context,(const VertHeader*)prim)));
        pre.block.set(rays);
        switch (type) {
        case blockType(kindLeaf ): return BlockIntersectorK<K,LeafVisitorK >::intersect(valid,rays,context,pre.block,(const Block*)prim);
        case blockType(kindVoxel): return BlockIntersectorK<K,VoxelVisitorK>::intersect(valid,rays,context,pre.block,(const Block*)prim);
        default:                   return BlockIntersectorK<K,GridVisitorK >::intersect(valid,rays,context,pre.block,(const Block*)prim);
        }
      }
    };

#if defined(EMBREE_RAY_PACKETS)
    DEFINE_INTERSECTOR4(BVH4CompressedSubdivIntersector4,BVHNIntersectorKHybrid<4 COMMA 4 COMMA nodesOfPackets COMMA true COMMA CompressedSubdivIntersectorK<4> >);
#if defined(__AVX__)
    DEFINE_INTERSECTOR8(BVH4CompressedSubdivIntersector8,BVHNIntersectorKHybrid<4 COMMA 8 COMMA nodesOfPackets COMMA true COMMA CompressedSubdivIntersectorK<8> >);
#endif
#if defined(__AVX512F__)
    DEFINE_INTERSECTOR16(BVH4CompressedSubdivIntersector16,BVHNIntersectorKHybrid<4 COMMA 16 COMMA nodesOfPackets COMMA true COMMA CompressedSubdivIntersectorK<16> >);
#endif
    /* streams: Embree's own fallback, which hands over packets */
    DEFINE_INTERSECTORN(BVH4CompressedSubdivIntersectorN,BVHNIntersectorStreamPacketFallback<4>);
#endif
  }
}
