// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "support/scene_blocks.h"
#include "kernels/bvh/bvh.h"
#include "kernels/cbvh/codec/primitive_type.h"
#include "kernels/common/scene.h"

namespace cbvh::test {

using namespace embree;

static void collect(BVH4::NodeRef ref, std::vector<const embree::cbvh::Block*>& blocks)
{
  if (ref == BVH4::emptyNode) return;
  if (ref.isAABBNode()) {
    for (size_t i = 0; i < 4; i++) collect(ref.getAABBNode()->child(i), blocks);
    return;
  }
  size_t type;
  const void* leaf = ref.leaf(type);
  if (type >= embree::cbvh::FIRST_BLOCK) blocks.push_back((const embree::cbvh::Block*)leaf);
}

std::vector<const embree::cbvh::Block*> sceneBlocks(RTCScene scene)
{
  std::vector<const embree::cbvh::Block*> blocks;
  for (const Accel* accel : ((const Scene*)scene)->accels)
    collect(((const BVH4*)accel->intersectors.ptr)->root, blocks);
  return blocks;
}

} // namespace cbvh::test
