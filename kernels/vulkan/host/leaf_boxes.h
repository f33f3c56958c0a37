// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The leaves of a scene's tree as boxes, by geometry, as a driver's bottom levels have them. */

#include "structures.h"
#include "tree.h"
#include "../scene_layout.h"

#include <functional>

namespace embree { namespace vulkan {

using cbvh::LeafBox;

/* Boxes of a geometry, in Morton order, each leaf once. */
struct LeafBoxes
{
  uint32_t geomID;   // all bits for triangles of meshes, of which leaves have those of several
  std::vector<LeafBox> boxes;

  /* What the driver gets: wider by what its arithmetic may lose. place: what becomes of bounds before. */
  std::vector<VkAabbPositionsKHR> forDriver(const std::function<Bounds(const Bounds&)>& place) const;
};

BoxesKey keyOf(const std::vector<VkAabbPositionsKHR>& boxes);

/* All below a subtree but instances. geomIDOf: of a reference. */
std::vector<LeafBoxes> leafBoxesOf(const Tree& tree, const Subtree& subtree, const std::function<uint32_t(uint32_t)>& geomIDOf);

}} // namespace embree::vulkan
