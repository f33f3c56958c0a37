// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The tree above everything that is traced: what libembree3 has for surfaces, and by
 * rtcBuildBVH the same over triangles and instances. */

#include "error.h"
#include "kernels/cbvh/flat/flat_scene.h"

#include <array>
#include <cstdint>
#include <vector>

namespace embree { namespace vulkan {

using cbvh::FlatNode;
using cbvh::FlatMovingNode;

struct Bounds
{
  float lower[3], upper[3];

  static Bounds empty();
  void extend(const float* point);
  void extend(const Bounds& other);
  bool isEmpty() const { return !(lower[0] <= upper[0]); }
};

/* A node or a leaf, and what is below it. */
struct Subtree
{
  uint32_t root = cbvh::emptyReference;
  Bounds bounds = Bounds::empty();
  uint32_t depth = 0;   // nodes on the longest way down
};

/* Something with bounds that a leaf refers to. */
struct Item
{
  Bounds bounds;
  uint32_t geomID, primID;
};

/* Throws VulkanError if so many things of a type have no reference each. */
void requireReferences(size_t count, const char* what);

class Tree
{
public:
  std::vector<FlatNode> nodes;
  std::vector<FlatMovingNode> movingNodes;
  std::vector<std::array<uint32_t, 2>> triangles;  // geomID and primID of those in runs

  /* Trees over triangles and over instances. Throw VulkanError. */
  Subtree buildTriangles(RTCDevice device, std::vector<Item>& items);
  Subtree buildInstances(RTCDevice device, std::vector<Item>& items);

  /* One node over up to four. */
  Subtree join(const std::vector<Subtree>& subtrees);

  uint32_t addNode();

private:
  Subtree build(RTCDevice device, std::vector<Item>& items, unsigned maxLeaf);
};

}} // namespace embree::vulkan
