// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The acceleration structures of a scene for ray queries: bottom levels of boxes, and a top level of instances. */

#include "leaf_boxes.h"
#include "memory.h"

#include <map>
#include <tuple>

namespace embree { namespace vulkan {

using cbvh::PlacedBoxes;

struct QueryStructures
{
  /* Origin of a bottom level: number of the instanced scene (0: the scene itself), geomID there, and the ID of the
   * instance if that moves. */
  typedef std::tuple<size_t, uint32_t, uint32_t> Place;
  std::map<Place, std::shared_ptr<const BottomLevel>> levels;
  std::vector<VkAccelerationStructureInstanceKHR> instances;
  std::shared_ptr<Structure> topLevel;
};

/* Add all levels and instances, then call build once. */
class QueryStructuresBuilder
{
public:
  /* previous: structures of the scene before an edit, whose bottom levels are updated if possible; or NULL. */
  QueryStructuresBuilder(Device& device, Uploader& uploader, const QueryStructures* previous)
    : device(device), uploader(uploader), previous(previous), input(new Arena(device)) {}

  /* Adds a bottom level over boxes after `place`. Returns its number. */
  size_t addLevel(const LeafBoxes& boxes, const QueryStructures::Place& from,
                  const std::function<Bounds(const Bounds&)>& place);

  /* transform: level to world, a 3x4 matrix column by column. */
  void addInstance(size_t level, const float* transform, const PlacedBoxes& place);

  /* Returns one entry per instance, in the order of addInstance. */
  const std::vector<PlacedBoxes>& placedBoxes() const { return places; }

  /* Writes the statistics of boxes and structures. arena: allocates the array of instances. */
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
