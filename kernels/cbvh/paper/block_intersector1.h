// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Intersects a single ray with a block: maps the ray into the block's frame (local_ray4.h), walks the block's quadtree
 * (block_walk1.h), and intersects leaves (the visitors). */

#include "voxel/visitor1.h"
#include "leaf/visitor1.h"
#include "grid/visitor1.h"

namespace embree::isa::cbvh {
/*! Visitor: LeafVisitor1, VoxelVisitor1 or GridVisitor1. Its constant `kind` is the block's kind. */
template<template<typename> class Visitor>
struct BlockIntersector1 {
  /*! Returns true if a hit was accepted. Any-hit queries end at the first one. Requires state.set() and a valid
   *  block. Not inlined, so that traversal keeps its ray in registers. */
  template<typename RayType>
  static __noinline bool intersect(RayType& ray, IntersectContext* context, const RayState& state, const Block* block) {
    LocalRay local;
    if (!local.init(state, block, ray.tfar)) return false;
    const NodeRay nodeRay(local);
    const BlockLayout layout = blockLayout(Visitor<RayType>::kind, block->height());
    BlockTiles tiles(block, layout);
    Visitor<RayType> visitor(ray, context, state, block, layout, local, nodeRay, tiles);
    BlockWalk1<Visitor<RayType>>(nodeRay, tiles, visitor).run();
    return visitor.isHit;
  }
};
} // namespace embree::isa::cbvh
