// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A scene's tree: libembree3's trees over blocks, and trees over triangles and instances by rtcBuildBVH. */

#include "error.h"
#include "kernels/cbvh/backend/flat_scene.h"

#include <array>
#include <cstdint>
#include <vector>

namespace embree::vulkan {

using cbvh::FlatNode;
using cbvh::FlatMovingNode;

struct Bounds {
  float lower[3], upper[3];

  static Bounds empty();
  void extend(const float* point);
  void extend(const Bounds& other);
  bool isEmpty() const { return !(lower[0] <= upper[0]); }
};

/* A subtree of a Tree, until join() connects it. */
struct Subtree {
  uint32_t root = cbvh::emptyReference;
  Bounds bounds = Bounds::empty();
  uint32_t depth = 0; // nodes on the longest path
};

/* A triangle, or an instance, whose primID is RTC_INVALID_GEOMETRY_ID. */
struct TreePrimitive {
  Bounds bounds;
  uint32_t geomID, primID;
};

/* Throws VulkanError if references cannot represent all indices below `count`. what: plural noun for the message. */
void requireIndexable(size_t count, const char* what);

class Tree {
public:
  std::vector<FlatNode> nodes;
  std::vector<FlatMovingNode> movingNodes;
  std::vector<std::array<uint32_t, 2>> triangles; // geomID and primID; leaves are runs of them

  /* Add a tree over the primitives, and free `primitives`, which may be large. */
  Subtree buildTriangles(RTCDevice device, std::vector<TreePrimitive>& primitives);
  Subtree buildInstances(RTCDevice device, std::vector<TreePrimitive>& primitives);

  /* Joins up to four subtrees under a new node, and returns the result. Omits empty subtrees; adds no node if at most
   * one is left. */
  Subtree join(const std::vector<Subtree>& subtrees);

  /* Returns the index of a new node without children. */
  uint32_t addNode();

private:
  Subtree build(RTCDevice device, std::vector<TreePrimitive>& primitives, unsigned maxLeafSize);
};

} // namespace embree::vulkan
