// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "tree.h"

#include <algorithm>
#include <atomic>
#include <limits>
#include <memory>
#include <new>

namespace embree::vulkan {

Bounds Bounds::empty() {
  const float inf = std::numeric_limits<float>::infinity();
  return {{inf, inf, inf}, {-inf, -inf, -inf}};
}

void Bounds::extend(const float* p) {
  for (int k = 0; k < 3; k++) {
    lower[k] = std::min(lower[k], p[k]);
    upper[k] = std::max(upper[k], p[k]);
  }
}

void Bounds::extend(const Bounds& other) {
  if (other.isEmpty()) return;
  extend(other.lower);
  extend(other.upper);
}

void requireIndexable(size_t count, const char* what) {
  const size_t maxCount = size_t(cbvh::maxReferenceIndex) + 1;
  if (count > maxCount)
    throw VulkanError(RTC_ERROR_INVALID_OPERATION, std::string("the scene has too many ") + what + ", at least " +
                                                       std::to_string(count) + ": expected at most " +
                                                       std::to_string(maxCount));
}

uint32_t Tree::addNode() {
  requireIndexable(nodes.size() + 1, "nodes");
  nodes.emplace_back();
  FlatNode& node = nodes.back();
  for (int i = 0; i < 4; i++) {
    node.children[i] = cbvh::emptyReference; // at infinity, where only rays with infinite tfar find it
    for (int k = 0; k < 3; k++) node.lower[k][i] = node.upper[k][i] = std::numeric_limits<float>::infinity();
  }
  return uint32_t(nodes.size() - 1);
}

namespace {

void setChild(FlatNode& node, int i, uint32_t child, const Bounds& bounds) {
  node.children[i] = child;
  for (int k = 0; k < 3; k++) {
    node.lower[k][i] = bounds.lower[k];
    node.upper[k][i] = bounds.upper[k];
  }
}

/* A node or leaf of rtcBuildBVH, in Embree's memory. Children are NULL if that memory ran out, see RanOutOfMemory. */
struct BuildNode {
  bool isLeaf;
  unsigned count = 0; // of children, or of the leaf's primitives
  RTCBounds bounds[4];
  BuildNode* children[4];
  std::array<uint32_t, 2> primitives[cbvh::maxRunLength]; // geomID and primID
};

/* True once a node or leaf could not be allocated, on any thread: Embree reports this to that thread only. */
typedef std::atomic<bool> RanOutOfMemory;

void* allocate(RTCThreadLocalAllocator allocator, void* ranOutOfMemory) {
  void* memory = rtcThreadLocalAlloc(allocator, sizeof(BuildNode), 16);
  if (!memory) *static_cast<RanOutOfMemory*>(ranOutOfMemory) = true;
  return memory;
}

void* createNode(RTCThreadLocalAllocator allocator, unsigned, void* ranOutOfMemory) {
  void* memory = allocate(allocator, ranOutOfMemory);
  if (!memory) return nullptr;
  BuildNode* node = new (memory) BuildNode;
  node->isLeaf = false;
  return node;
}

void setChildren(void* pointer, void** children, unsigned count, void*) {
  BuildNode* node = static_cast<BuildNode*>(pointer);
  if (!node) return;
  node->count = count;
  for (unsigned i = 0; i < count; i++) node->children[i] = static_cast<BuildNode*>(children[i]);
}

void setBounds(void* pointer, const RTCBounds** bounds, unsigned count, void*) {
  if (!pointer) return;
  for (unsigned i = 0; i < count; i++) static_cast<BuildNode*>(pointer)->bounds[i] = *bounds[i];
}

void* createLeaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, size_t count,
                 void* ranOutOfMemory) {
  void* memory = allocate(allocator, ranOutOfMemory);
  if (!memory) return nullptr;
  BuildNode* leaf = new (memory) BuildNode;
  leaf->isLeaf = true;
  leaf->count = unsigned(count);
  for (size_t i = 0; i < count; i++) leaf->primitives[i] = {primitives[i].geomID, primitives[i].primID};
  return leaf;
}

struct BVHDeleter {
  void operator()(RTCBVHTy* bvh) const { rtcReleaseBVH(bvh); }
};

class TreeCopier {
public:
  explicit TreeCopier(Tree& tree) : tree(tree) {}

  uint32_t depth = 0;

  /* Copies a subtree without NULL, and returns a reference to the copy. nodesAbove: number of nodes above it. */
  uint32_t copySubtree(const BuildNode* from, uint32_t nodesAbove) {
    if (from->isLeaf) return copyLeaf(from);
    depth = std::max(depth, nodesAbove + 1);
    const uint32_t n = tree.addNode();
    for (unsigned i = 0; i < from->count; i++) {
      const uint32_t child = copySubtree(from->children[i], nodesAbove + 1);
      const RTCBounds& b = from->bounds[i];
      setChild(tree.nodes[n], int(i), child, {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}});
    }
    return cbvh::makeReference(cbvh::nodeReferenceType, n);
  }

private:
  uint32_t copyLeaf(const BuildNode* from) {
    const uint32_t geomID = from->primitives[0][0], primID = from->primitives[0][1];
    if (primID == RTC_INVALID_GEOMETRY_ID) { // an instance, see TreePrimitive; buildInstances puts one into each leaf
      requireIndexable(size_t(geomID) + 1, "geometries");
      return cbvh::makeReference(cbvh::instanceReferenceType, geomID);
    }
    requireIndexable(tree.triangles.size() + from->count, "triangles");
    const uint32_t first = uint32_t(tree.triangles.size());
    for (unsigned i = 0; i < from->count; i++) tree.triangles.push_back(from->primitives[i]);
    return cbvh::makeRunReference(first, from->count);
  }

  Tree& tree;
};

} // namespace

Subtree Tree::build(RTCDevice device, std::vector<TreePrimitive>& primitives, unsigned maxLeafSize) {
  Subtree out;
  if (primitives.empty()) return out;
  std::vector<RTCBuildPrimitive> input(primitives.size());
  for (size_t i = 0; i < primitives.size(); i++) {
    const TreePrimitive& p = primitives[i];
    out.bounds.extend(p.bounds);
    input[i] = {p.bounds.lower[0], p.bounds.lower[1], p.bounds.lower[2], p.geomID,
                p.bounds.upper[0], p.bounds.upper[1], p.bounds.upper[2], p.primID};
  }
  std::vector<TreePrimitive>().swap(primitives);
  std::unique_ptr<RTCBVHTy, BVHDeleter> bvh(rtcNewBVH(device));
  RTCBuildArguments args = rtcDefaultBuildArguments();
  args.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  args.maxBranchingFactor = 4;
  args.minLeafSize = 1;
  args.maxLeafSize = maxLeafSize;
  args.bvh = bvh.get();
  args.primitives = input.data();
  args.primitiveCount = args.primitiveArrayCapacity = input.size();
  args.createNode = createNode;
  args.setNodeChildren = setChildren;
  args.setNodeBounds = setBounds;
  args.createLeaf = createLeaf;
  RanOutOfMemory ranOutOfMemory(false);
  args.userPtr = &ranOutOfMemory;
  const BuildNode* root = bvh ? static_cast<const BuildNode*>(rtcBuildBVH(&args)) : nullptr;
  std::vector<RTCBuildPrimitive>().swap(input);
  if (ranOutOfMemory)
    throw VulkanError(RTC_ERROR_OUT_OF_MEMORY, "Embree has no memory for a tree over triangles or instances");
  if (!root) throw VulkanError(RTC_ERROR_NONE, "Embree built no tree, and reported why");
  TreeCopier copier(*this);
  out.root = copier.copySubtree(root, 0);
  out.depth = copier.depth;
  return out;
}

Subtree Tree::buildTriangles(RTCDevice device, std::vector<TreePrimitive>& primitives) {
  return build(device, primitives, cbvh::maxRunLength);
}

Subtree Tree::buildInstances(RTCDevice device, std::vector<TreePrimitive>& primitives) {
  return build(device, primitives, 1);
}

Subtree Tree::join(const std::vector<Subtree>& subtrees) {
  std::vector<Subtree> nonEmpty;
  for (const Subtree& subtree : subtrees)
    if (subtree.root != cbvh::emptyReference) nonEmpty.push_back(subtree);
  if (nonEmpty.empty()) return Subtree();
  if (nonEmpty.size() == 1) return nonEmpty[0];
  Subtree out;
  const uint32_t n = addNode();
  out.root = cbvh::makeReference(cbvh::nodeReferenceType, n);
  for (size_t i = 0; i < nonEmpty.size(); i++) {
    setChild(nodes[n], int(i), nonEmpty[i].root, nonEmpty[i].bounds);
    out.bounds.extend(nonEmpty[i].bounds);
    out.depth = std::max(out.depth, nonEmpty[i].depth + 1);
  }
  return out;
}

} // namespace embree::vulkan
