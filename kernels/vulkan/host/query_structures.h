// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A scene's acceleration structures for ray queries: bottom levels of boxes, and a top level of instances. */

#include "leaf_boxes.h"
#include "memory.h"

#include <functional>
#include <map>
#include <tuple>

namespace embree { namespace vulkan {

using cbvh::PlacedBoxes;

struct QueryStructures
{
  /* Origin of a bottom level: instanced scene (0: the scene itself), geomID there, and ID of a moving instance. */
  typedef std::tuple<size_t, uint32_t, uint32_t> Place;
  std::map<Place, std::shared_ptr<const BottomLevel>> levels;
  std::vector<VkAccelerationStructureInstanceKHR> instances;
  std::shared_ptr<Structure> topLevel;
};

/* Add all levels and instances, then call build once. */
class QueryStructuresBuilder
{
public:
  /* previous: the scene's structures before an edit, whose bottom levels are updated if possible, or NULL. */
  QueryStructuresBuilder(Device& device, Uploader& uploader, const QueryStructures* previous)
    : device(device), uploader(uploader), previous(previous), input(new Arena(device)) {}

  /* Returns the number of the bottom level over boxes after `place`. */
  size_t addLevel(const LeafBoxes& boxes, const QueryStructures::Place& from,
                  const std::function<Bounds(const Bounds&)>& place);

  /* transform: level to world, a 3x4 matrix column by column. */
  void addInstance(size_t level, const float* transform, const PlacedBoxes& place);

  /* One per instance, in the order of addInstance. */
  const std::vector<PlacedBoxes>& placedBoxes() const { return places; }

  /* Sets the statistics of boxes and structures. arena: for the array of instances. */
  void build(Arena& arena, QueryStructures& out, RTCVulkanSceneStatistics& statistics);

private:
  Device& device;
  Uploader& uploader;
  const QueryStructures* const previous;
  std::unique_ptr<Arena> input;                // boxes; freed after the build
  std::vector<WantedLevel> wanted;
  std::vector<QueryStructures::Place> froms;   // place of each level in `wanted`
  std::vector<VkAccelerationStructureInstanceKHR> instances;
  std::vector<PlacedBoxes> places;
};

}} // namespace embree::vulkan
