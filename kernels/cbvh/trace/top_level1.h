// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Traversal of the top-level BVH by one ray for the closest hit: Embree's, and it tells a leaf where the ray
 * enters its bounds. Blocks reach a little past their bounds (build/block_bounds.h); as their hits lie where
 * the ray has entered these, or behind, it does not matter in what order blocks are met. */

#include "../../bvh/bvh_intersector1.cpp"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! Leaves::intersect(leaf, enter, tray, lazyNode): enter is where the ray enters the bounds of a leaf */
      template<typename Leaves>
      __forceinline void traverseClosestHit1 (BVH4::NodeRef root, RayHit& ray, Leaves& leaves)
      {
        typedef BVH4::NodeRef NodeRef;
        typedef StackItemT<NodeRef> Entry;

        TravRay<4,true> tray(ray.org,ray.dir,max(ray.tnear(),0.0f),max(ray.tfar,0.0f));
        Entry stack[1+3*BVH4::maxDepth+3]; // it is written 16 wide
        Entry* top = stack+1;
        stack[0].ptr = root;
        stack[0].dist = neg_inf;
        while (top != stack)
        {
          top--;
          NodeRef cur = NodeRef(top->ptr);
          float enter;
          memcpy(&enter,&top->dist,sizeof(float));
          if (unlikely(enter > ray.tfar)) continue;

          size_t mask = 1;
          vfloat4 distances(enter);
          while (!cur.isLeaf())
          {
            mask = intersectNodeRobust<4>(cur.getAABBNode(),tray,distances);
            if (unlikely(mask == 0)) break;
            BVHNNodeTraverser1Hit<4,BVH_AN1>::traverseClosestHit(cur,mask,distances,top,stack+sizeof(stack)/sizeof(Entry));
          }
          if (unlikely(mask == 0)) continue;

          size_t lazyNode = 0;
          leaves.intersect(cur,reduce_min(select(vboolf4(int(mask)),distances,vfloat4(pos_inf))),tray,lazyNode);
          tray.tfar = ray.tfar;
          if (unlikely(lazyNode)) {
            top->ptr = lazyNode;
            top->dist = neg_inf;
            top++;
          }
        }
      }
    }
  }
}
