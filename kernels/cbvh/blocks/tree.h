// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Trees above static blocks, from Embree's binned SAH builder for BVH4. A large surface has a tree over its blocks, a
 * scene a tree over parts of its surfaces: subtrees of a few blocks. This is fast to build, and as good as a tree over
 * all blocks. Moving blocks have building/motion_tree.h instead. */

#include "../embree/scene.h"

namespace embree::isa {
/*! Maximum number of blocks in a part. */
static const size_t maxPartBlocks = 16;

/*! Counts the nodes above leaves with Embree's barrier bit, and clears the bits. A leaf can be a subtree, whose
 *  nodes are not counted. */
inline size_t countNodes(BVH4::NodeRef& ref) {
  if (ref.isBarrier()) {
    ref.clearBarrier();
    return 0;
  }
  if (ref == BVH4::emptyNode) return 0;
  size_t n = 1;
  for (size_t i = 0; i < 4; i++) n += countNodes(ref.getAABBNode()->child(i));
  return n;
}

/*! Builds a tree with one leaf per primitive and returns its root. prims: bounds, and as ID the BVH4::NodeRef of a
 *  block or subtree; reordered. nodes: set to the number of nodes. progress() may throw to cancel. */
template<typename Progress>
inline BVH4::NodeRef buildTree(FastAllocator& memory, mvector<PrimRef>& prims, const Progress& progress,
                               size_t& nodes) {
  PrimInfo info(empty);
  for (const PrimRef& prim : prims) info.add_center2(prim);
  const PrimInfo pinfo(0, prims.size(), info);
  auto createLeaf = [&](const PrimRef* prims, const range<size_t>& range,
                        FastAllocator::CachedAllocator) -> BVH4::NodeRef {
    BVH4::NodeRef leaf = size_t(prims[range.begin()].ID());
    leaf.setBarrier();
    return leaf;
  };
  auto monitor = [&](size_t) { progress(); };
  auto virtualMonitor = BuildProgressMonitorFromClosure(monitor);

  GeneralBVHBuilder::Settings settings;
  settings.logBlockSize = bsr(4);
  settings.minLeafSize = 1;
  settings.maxLeafSize = 1;
  settings.travCost = 1.0f;
  settings.intCost = 1.0f;
  settings.singleThreadThreshold = DEFAULT_SINGLE_THREAD_THRESHOLD;
  BVH4::NodeRef root = BVHNBuilderVirtual<4>::build(&memory, createLeaf, virtualMonitor, prims.data(), pinfo, settings);
  nodes = countNodes(root);
  return root;
}

/*! Copies the largest nodes, which most rays traverse, next to each other. Returns the new root. The old nodes, at
 *  most half a percent, stay allocated. Nodes of parts, which surfaces own, are not changed. */
inline BVH4::NodeRef moveLargestNodes(BVH4::NodeRef root, size_t numNodes, FastAllocator& memory) {
  const size_t count = numNodes / 200;
  struct Candidate {
    BVH4::NodeRef* node;
    float area;
    bool operator<(const Candidate& other) const { return area < other.area; }
  };
  std::vector<Candidate> candidates; // a heap
  if (root.isAABBNode()) candidates.push_back(Candidate{&root, 0.0f});
  for (size_t numMoved = 0; numMoved < count && !candidates.empty(); numMoved++) {
    std::pop_heap(candidates.begin(), candidates.end());
    const Candidate largest = candidates.back();
    candidates.pop_back();
    BVH4::AABBNode* node =
        (BVH4::AABBNode*)memory.getCachedAllocator().malloc0(sizeof(BVH4::AABBNode), BVH4::byteNodeAlignment);
    *node = *largest.node->getAABBNode();
    *largest.node = BVH4::encodeNode(node);
    for (size_t i = 0; i < 4; i++) {
      if (node->child(i) == BVH4::emptyNode || !node->child(i).isAABBNode()) continue;
      candidates.push_back(Candidate{&node->child(i), area(node->bounds(i))});
      std::push_heap(candidates.begin(), candidates.end());
    }
  }
  return root;
}

/*! Divides a tree into parts: appends the largest subtrees with at most maxPartBlocks leaves to `parts`. */
class TreeCutter {
public:
  explicit TreeCutter(mvector<PrimRef>& parts) : parts(parts) {}

  void cut(BVH4::NodeRef root, const BBox3fa& bounds) {
    const size_t leaves = visit(root, bounds);
    if (leaves && leaves <= maxPartBlocks) parts.push_back(PrimRef(bounds, size_t(root)));
  }

private:
  /*! Returns the number of leaves. If they are too many for a part, appends the children that are parts. */
  size_t visit(BVH4::NodeRef ref, const BBox3fa& bounds) {
    if (ref == BVH4::emptyNode) return 0;
    if (!ref.isAABBNode()) return 1;
    const BVH4::AABBNode* node = ref.getAABBNode();
    size_t leaves[4], sum = 0;
    for (size_t i = 0; i < 4; i++) sum += leaves[i] = visit(node->child(i), node->bounds(i));
    if (sum <= maxPartBlocks) return sum;
    for (size_t i = 0; i < 4; i++)
      if (leaves[i] && leaves[i] <= maxPartBlocks) parts.push_back(PrimRef(node->bounds(i), size_t(node->child(i))));
    return sum;
  }

  mvector<PrimRef>& parts;
};
} // namespace embree::isa
