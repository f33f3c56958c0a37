// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A scene's acceleration structures for ray queries: bottom levels of boxes (LeafBox), and a top level of instances.
 * The driver finds boxes, and shaders/ray_query.glsl intersects their leaves. */

#include "leaf_boxes.h"
#include "memory.h"

#include <functional>
#include <map>
#include <tuple>

namespace embree::vulkan {

using cbvh::PlacedBoxes;

struct QueryStructures {
  /* Identifies a bottom level: number of the instanced scene (0: the scene itself), LeafBoxes::geomID there, and geomID
   * of the moving instance that it belongs to, or RTC_INVALID_GEOMETRY_ID. */
  typedef std::tuple<size_t, uint32_t, uint32_t> LevelID;
  std::map<LevelID, std::shared_ptr<const BottomLevel>> levels;
  std::vector<VkAccelerationStructureInstanceKHR> instances;
  std::shared_ptr<Structure> topLevel;
};

/* Builds QueryStructures. Add all levels and instances, then call build() once. */
class QueryStructuresBuilder {
public:
  /* previous: structures of the scene before an edit, from which new ones are updated if possible, or NULL. */
  QueryStructuresBuilder(Device& device, Uploader& uploader, const QueryStructures* previous)
    : device(device),
      uploader(uploader),
      previous(previous),
      input(new Arena(device)) {}

  /* Adds a bottom level over transformed boxes. Reuses a level of the device with the same boxes. Returns its number,
   * for addInstance. */
  size_t addLevel(const LeafBoxes& boxes, const QueryStructures::LevelID& id,
                  const std::function<Bounds(const Bounds&)>& transform);

  /* Adds an instance of a level. transform: from the level's space to world space, a 3x4 matrix column by column. */
  void addInstance(size_t level, const float* transform, const PlacedBoxes& boxes);

  /* One per instance, in the order of addInstance. */
  const std::vector<PlacedBoxes>& placedBoxes() const { return placed; }

  /* Builds all levels that are not reused, and the top level. Sets the statistics of boxes and structures. arena: for
   * the array of instances. */
  void build(Arena& arena, QueryStructures& out, RTCVulkanSceneStatistics& statistics);

private:
  Device& device;
  Uploader& uploader;
  const QueryStructures* const previous;
  std::unique_ptr<Arena> input; // boxes; freed after the build
  std::vector<LevelRequest> requests;
  std::vector<QueryStructures::LevelID> levelIDs; // of each level in `requests`
  std::vector<VkAccelerationStructureInstanceKHR> instances;
  std::vector<PlacedBoxes> placed;
};

} // namespace embree::vulkan
