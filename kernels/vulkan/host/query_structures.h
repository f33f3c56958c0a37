// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What ray queries need of a scene: bottom levels of boxes, and where instances place them. */

#include "leaf_boxes.h"
#include "memory.h"

#include <map>
#include <tuple>

namespace embree { namespace vulkan {

using cbvh::PlacedBoxes;

struct QueryStructures
{
  /* Where a bottom level comes from: 0 for the scene or the number of an instanced one, geomID there, and the ID of the instance, if that moves. */
  typedef std::tuple<size_t, uint32_t, uint32_t> Place;
  std::map<Place, std::shared_ptr<const BottomLevel>> levels;
  std::vector<VkAccelerationStructureInstanceKHR> instances;
  std::shared_ptr<Structure> topLevel;
};

/* Makes them: levels and instances are added, then all are built. */
class QueryStructuresBuilder
{
public:
  /* previous: of a scene before an edit, or NULL. */
  QueryStructuresBuilder(Device& device, Uploader& uploader, const QueryStructures* previous)
    : device(device), uploader(uploader), previous(previous), input(new Arena(device)) {}

  /* A bottom level of boxes, where `place` takes their bounds. Returns its number. */
  size_t addLevel(const LeafBoxes& boxes, const QueryStructures::Place& from, const std::function<Bounds(const Bounds&)>& place);

  /* transform: to the world, column by column. */
  void addInstance(size_t level, const float* transform, const PlacedBoxes& place);

  /* Of the instances, in their order. */
  const std::vector<PlacedBoxes>& placedBoxes() const { return places; }

  /* arena: of the instances. statistics: of boxes and structures are written. Throws VulkanError. */
  void build(Arena& arena, QueryStructures& out, RTCVulkanSceneStatistics& statistics);

private:
  Device& device;
  Uploader& uploader;
  const QueryStructures* const previous;
  std::unique_ptr<Arena> input;   // of what is built; gone when it is
  std::vector<WantedLevel> wanted;
  std::vector<QueryStructures::Place> froms;   // of each
  std::vector<VkAccelerationStructureInstanceKHR> instances;
  std::vector<PlacedBoxes> places;
};

}} // namespace embree::vulkan
