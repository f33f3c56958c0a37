// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Boxes of a tree's leaves, per geometry: input of bottom-level acceleration structures. */

#include "structures.h"
#include "tree.h"
#include "../scene_layout.h"

#include <functional>

namespace embree::vulkan {

using cbvh::LeafBox;

struct LeafBoxes {
  uint32_t geomID;            // RTC_INVALID_GEOMETRY_ID for triangles, because a leaf may mix meshes
  std::vector<LeafBox> boxes; // in Morton order

  /* The boxes as input of a driver's build: transformed, and enlarged for the rounding errors of drivers. */
  std::vector<VkAabbPositionsKHR> driverBoxes(const std::function<Bounds(const Bounds&)>& transform) const;
};

/* Leaves below a subtree, each once, without instances. geomIDOf(reference) returns the geomID of a leaf. */
std::vector<LeafBoxes> leafBoxesOf(const Tree& tree, const Subtree& subtree,
                                   const std::function<uint32_t(uint32_t)>& geomIDOf);

} // namespace embree::vulkan
