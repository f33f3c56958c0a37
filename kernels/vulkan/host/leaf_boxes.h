// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Boxes of a tree's leaves, per geometry: input of bottom-level acceleration structures. */

#include "structures.h"
#include "tree.h"
#include "../scene_layout.h"

#include <functional>

namespace embree { namespace vulkan {

using cbvh::LeafBox;

struct LeafBoxes
{
  uint32_t geomID;              // all bits set for triangle meshes, whose leaves mix geometries
  std::vector<LeafBox> boxes;   // in Morton order

  /* The boxes after `place`, enlarged by rounding errors of drivers. */
  std::vector<VkAabbPositionsKHR> forDriver(const std::function<Bounds(const Bounds&)>& place) const;
};

BoxesKey keyOf(const std::vector<VkAabbPositionsKHR>& boxes);

/* Leaves below a subtree, each once, without instances. geomIDOf: geomID of a reference. */
std::vector<LeafBoxes> leafBoxesOf(const Tree& tree, const Subtree& subtree,
                                   const std::function<uint32_t(uint32_t)>& geomIDOf);

}} // namespace embree::vulkan
