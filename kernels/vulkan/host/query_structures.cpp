// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "query_structures.h"

#include <algorithm>
#include <set>

namespace embree::vulkan {
namespace {

/* Converts a 3x4 matrix from columns to Vulkan's rows. */
VkTransformMatrixKHR matrixOf(const float* columns) {
  VkTransformMatrixKHR out;
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 4; column++) out.matrix[row][column] = columns[3 * column + row];
  return out;
}

} // namespace

size_t QueryStructuresBuilder::addLevel(const LeafBoxes& boxes, const QueryStructures::LevelID& id,
                                        const std::function<Bounds(const Bounds&)>& transform) {
  LevelRequest request = {BoxesKey(boxes.driverBoxes(transform)), 0, nullptr, nullptr};
  const std::vector<VkAabbPositionsKHR>& driverBoxes = request.key.boxes();
  request.level = device.structures.find(request.key);
  if (!request.level) {
    const Slice slice = input->allocate(driverBoxes.size() * sizeof(driverBoxes[0]), "boxes to build structures from");
    uploader.write(slice, 0, driverBoxes.data(), driverBoxes.size() * sizeof(driverBoxes[0]));
    request.boxes = slice.address();
  }
  if (previous) {
    const auto found = previous->levels.find(id);
    if (found != previous->levels.end() && found->second->key.boxes().size() == driverBoxes.size())
      request.previous = found->second;
  }
  requests.push_back(request);
  levelIDs.push_back(id);
  return requests.size() - 1;
}

void QueryStructuresBuilder::addInstance(size_t level, const float* transform, const PlacedBoxes& boxes) {
  if (placed.size() >= device.capabilities.maxInstances)
    throw VulkanError(RTC_ERROR_INVALID_OPERATION, "the scene has too many instances for ray queries: "
                                                   "expected at most " +
                                                       std::to_string(device.capabilities.maxInstances));
  VkAccelerationStructureInstanceKHR instance = {};
  instance.transform = matrixOf(transform);
  instance.instanceCustomIndex = uint32_t(placed.size());
  instance.mask = 0xFF;
  instance.accelerationStructureReference = level; // index in requests; build() replaces it by an address
  instances.push_back(instance);
  placed.push_back(boxes);
}

void QueryStructuresBuilder::build(Arena& arena, QueryStructures& out, RTCVulkanSceneStatistics& statistics) {
  uploader.flush();
  const BuildCounts counts = buildBottomLevels(device, requests);
  input.reset();
  size_t numBoxes = 0, structureBytes = 0;
  std::set<const Structure*> counted; // levels with the same boxes share a structure
  for (size_t i = 0; i < requests.size(); i++) {
    const Structure& structure = *requests[i].level->structure;
    out.levels[levelIDs[i]] = requests[i].level;
    if (!counted.insert(&structure).second) continue;
    structureBytes += structure.bytes;
    numBoxes += requests[i].key.boxes().size();
  }
  for (auto& instance : instances)
    instance.accelerationStructureReference =
        requests[instance.accelerationStructureReference].level->structure->address;
  const size_t size = instances.size() * sizeof(instances[0]);
  const Slice slice = arena.allocate(std::max(size, size_t(1)), "instances for ray queries");
  if (size != 0) uploader.write(slice, 0, instances.data(), size);
  uploader.flush();
  out.topLevel = buildTopLevel(device, slice.address(), instances.size());
  out.instances = std::move(instances);
  statistics.numBoxes = numBoxes;
  statistics.numBuiltBoxes = counts.built;
  statistics.numUpdatedBoxes = counts.updated;
  statistics.structureBytes = out.topLevel->bytes + structureBytes;
}

} // namespace embree::vulkan
