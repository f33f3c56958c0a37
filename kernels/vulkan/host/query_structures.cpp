// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "query_structures.h"

#include <algorithm>

namespace embree { namespace vulkan {
namespace {

/* Converts a 3x4 matrix from columns to Vulkan's rows. */
VkTransformMatrixKHR matrixOf(const float* columns)
{
  VkTransformMatrixKHR out;
  for (int row = 0; row < 3; row++)
    for (int column = 0; column < 4; column++) out.matrix[row][column] = columns[3*column + row];
  return out;
}

} // namespace

size_t QueryStructuresBuilder::addLevel(const LeafBoxes& boxes, const QueryStructures::Place& from,
                                        const std::function<Bounds(const Bounds&)>& place)
{
  const std::vector<VkAabbPositionsKHR> forDriver = boxes.forDriver(place);
  WantedLevel want = {keyOf(forDriver), 0, nullptr, nullptr};
  want.level = device.structures.find(want.key);
  if (!want.level) {
    const Slice slice = input->take(forDriver.size()*sizeof(forDriver[0]), "boxes to build structures from");
    uploader.write(slice, 0, forDriver.data(), forDriver.size()*sizeof(forDriver[0]));
    want.boxes = slice.address();
  }
  if (previous) {
    const auto found = previous->levels.find(from);
    if (found != previous->levels.end() && found->second->key.count == want.key.count) want.previous = found->second;
  }
  wanted.push_back(want);
  froms.push_back(from);
  return wanted.size() - 1;
}

void QueryStructuresBuilder::addInstance(size_t level, const float* transform, const PlacedBoxes& place)
{
  if (places.size() >= device.capabilities.maxInstances)
    throw VulkanError(RTC_ERROR_INVALID_OPERATION, "the scene has too many instances for ray queries: "
                      + std::to_string(device.capabilities.maxInstances) + " at most");
  VkAccelerationStructureInstanceKHR instance = {};
  instance.transform = matrixOf(transform);
  instance.instanceCustomIndex = uint32_t(places.size());
  instance.mask = 0xFF;
  instance.accelerationStructureReference = level;   // number of the level; build() replaces it by an address
  instances.push_back(instance);
  places.push_back(place);
}

void QueryStructuresBuilder::build(Arena& arena, QueryStructures& out, RTCVulkanSceneStatistics& statistics)
{
  uploader.flush();
  const BuildCounts counts = buildBottomLevels(device, wanted);
  input.reset();
  std::map<const Structure*, size_t> bytes;   // counts shared structures once
  for (size_t i = 0; i < wanted.size(); i++) {
    const Structure& structure = *wanted[i].level->structure;
    out.levels[froms[i]] = wanted[i].level;
    bytes[&structure] = structure.bytes;
    statistics.numBoxes += wanted[i].key.count;
  }
  for (auto& instance : instances)
    instance.accelerationStructureReference
      = wanted[instance.accelerationStructureReference].level->structure->address;
  const size_t size = instances.size()*sizeof(instances[0]);
  const Slice slice = arena.take(std::max(size, size_t(1)), "instances for ray queries");
  uploader.write(slice, 0, instances.data(), size);
  uploader.flush();
  out.topLevel = buildTopLevel(device, slice.address(), instances.size());
  out.instances = std::move(instances);
  statistics.numBuiltBoxes = counts.built;
  statistics.numUpdatedBoxes = counts.updated;
  statistics.structureBytes = out.topLevel->bytes;
  for (const auto& entry : bytes) statistics.structureBytes += entry.second;
}

}} // namespace embree::vulkan
