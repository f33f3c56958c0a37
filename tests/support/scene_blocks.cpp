// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "support/scene_blocks.h"
#include "kernels/bvh/bvh.h"
#include "kernels/cbvh/base/leaf_type.h"
#include "kernels/common/scene.h"

namespace programs::test {

using namespace embree;

// Calls visit(type, leaf) for all leaves of the top level.
template<typename Visit>
static void forEachLeaf(BVH4::NodeRef ref, const Visit& visit) {
  if (ref == BVH4::emptyNode) return;
  if (ref.isAABBNode()) {
    for (size_t i = 0; i < 4; i++) forEachLeaf(ref.getAABBNode()->child(i), visit);
    return;
  }
  size_t type;
  const void* leaf = ref.leaf(type);
  visit(type, leaf);
}

template<typename Visit>
static void forEachLeaf(RTCScene scene, const Visit& visit) {
  for (const Accel* accel : ((const Scene*)scene)->accels)
    forEachLeaf(((const BVH4*)accel->intersectors.ptr)->root, visit);
}

std::vector<const embree::cbvh::Block*> sceneBlocks(RTCScene scene) {
  using namespace embree::cbvh;
  std::vector<const Block*> blocks;
  forEachLeaf(scene, [&](size_t type, const void* leaf) {
    if (type == FRAMED_BLOCK) blocks.push_back((const Block*)leaf);
  });
  return blocks;
}

std::vector<const cvert::VertHeader*> sceneVertBlocks(RTCScene scene) {
  using namespace embree::cbvh;
  std::vector<const VertHeader*> blocks;
  forEachLeaf(scene, [&](size_t type, const void* leaf) {
    if (type == VERT_BLOCK || type == TILE_BLOCK) blocks.push_back((const VertHeader*)leaf);
  });
  return blocks;
}

unsigned geometryOf(RTCScene scene, uint32_t surface) { return ((const Scene*)scene)->surfaceIDs[surface]; }

} // namespace programs::test
