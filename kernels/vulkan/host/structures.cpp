// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "leaf_boxes.h"
#include "memory.h"

#include <algorithm>

namespace embree::vulkan {

/* --- structures of a device --------------------------------------------------------------- */

std::shared_ptr<const BottomLevel> Structures::find(const BoxesKey& key) const {
  std::lock_guard<std::mutex> lock(mutex);
  const auto sameHash = levels.equal_range(key.hash());
  for (auto entry = sameHash.first; entry != sameHash.second; ++entry)
    if (const std::shared_ptr<const BottomLevel> level = entry->second.lock())
      if (level->key == key) return level;
  return nullptr;
}

void Structures::add(const std::shared_ptr<const BottomLevel>& level) {
  std::lock_guard<std::mutex> lock(mutex);
  levels.insert({level->key.hash(), level});
}

void Structures::removeExpired() {
  std::lock_guard<std::mutex> lock(mutex);
  for (auto level = levels.begin(); level != levels.end();)
    level = level->second.expired() ? levels.erase(level) : std::next(level);
}

Structure::Structure(Device& device, VkAccelerationStructureTypeKHR type, const std::shared_ptr<Buffer>& memory,
                     size_t offset, size_t bytes)
  : bytes(bytes),
    device(device),
    memory(memory) {
  VkAccelerationStructureCreateInfoKHR info = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
  info.buffer = memory->handle;
  info.offset = offset;
  info.size = bytes;
  info.type = type;
  check(device.vk.CreateAccelerationStructureKHR(device.handles.device, &info, nullptr, &handle),
        "creating a structure of " + std::to_string(bytes) + " bytes for ray queries");
  VkAccelerationStructureDeviceAddressInfoKHR addressInfo = {
      VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR};
  addressInfo.accelerationStructure = handle;
  address = device.vk.GetAccelerationStructureDeviceAddressKHR(device.handles.device, &addressInfo);
}

Structure::~Structure() { device.vk.DestroyAccelerationStructureKHR(device.handles.device, handle, nullptr); }

/* --- building ----------------------------------------------------------------------------- */

namespace {

constexpr size_t structureAlignment = 256; // alignment that Vulkan requires

size_t roundedUp(size_t bytes, size_t alignment) { return (bytes + alignment - 1) / alignment * alignment; }

/* A build or update of an acceleration structure. */
struct Build {
  VkAccelerationStructureTypeKHR type;
  VkAccelerationStructureGeometryKHR geometry;
  uint32_t count;                       // of boxes or instances
  VkAccelerationStructureKHR from;      // source of an update, or VK_NULL_HANDLE
  size_t bytes, scratch;                // set by measure()
  std::shared_ptr<Structure> structure; // set by buildTogether()

  VkAccelerationStructureBuildGeometryInfoKHR info() const {
    VkAccelerationStructureBuildGeometryInfoKHR info = {
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
    info.type = type;
    info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    if (type == VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR)
      info.flags |= VK_BUILD_ACCELERATION_STRUCTURE_ALLOW_UPDATE_BIT_KHR;
    info.mode = from ? VK_BUILD_ACCELERATION_STRUCTURE_MODE_UPDATE_KHR : VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info.srcAccelerationStructure = from;
    info.dstAccelerationStructure = structure ? structure->handle : VK_NULL_HANDLE;
    info.geometryCount = 1;
    info.pGeometries = &geometry;
    return info;
  }

  void measure(Device& device) {
    VkAccelerationStructureBuildSizesInfoKHR sizes = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    const VkAccelerationStructureBuildGeometryInfoKHR geometryInfo = info();
    device.vk.GetAccelerationStructureBuildSizesKHR(
        device.handles.device, VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &geometryInfo, &count, &sizes);
    bytes = size_t(sizes.accelerationStructureSize);
    scratch = size_t(from ? sizes.updateScratchSize : sizes.buildScratchSize);
  }
};

void addBarrier(Device& device, VkCommandBuffer commands, VkAccessFlags from, VkPipelineStageFlags fromStage,
                VkAccessFlags to, VkPipelineStageFlags toStage) {
  VkMemoryBarrier barrier = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  barrier.srcAccessMask = from;
  barrier.dstAccessMask = to;
  device.vk.CmdPipelineBarrier(commands, fromStage, toStage, 0, 1, &barrier, 0, nullptr, 0, nullptr);
}

/* Builds with one command, into one shared buffer. Waits for the device. */
void buildTogether(Device& device, Build* builds, size_t count) {
  const size_t alignment = device.capabilities.scratchAlignment;
  size_t bytes = 0, scratchBytes = alignment;
  for (size_t i = 0; i < count; i++) {
    bytes += roundedUp(builds[i].bytes, structureAlignment);
    scratchBytes += roundedUp(builds[i].scratch, alignment);
  }
  const auto memory = std::make_shared<Buffer>(device, bytes, Buffer::OnDevice, "structures for ray queries");
  const Buffer scratch(device, scratchBytes, Buffer::OnDevice, "scratch memory of structures for ray queries");
  std::vector<VkAccelerationStructureBuildGeometryInfoKHR> infos;
  std::vector<VkAccelerationStructureBuildRangeInfoKHR> ranges;
  std::vector<const VkAccelerationStructureBuildRangeInfoKHR*> pointers;
  size_t offset = 0, scratchAddress = roundedUp(scratch.address, alignment);
  for (size_t i = 0; i < count; i++) {
    builds[i].structure = std::make_shared<Structure>(device, builds[i].type, memory, offset, builds[i].bytes);
    infos.push_back(builds[i].info());
    infos.back().scratchData.deviceAddress = scratchAddress;
    ranges.push_back({builds[i].count, 0, 0, 0});
    offset += roundedUp(builds[i].bytes, structureAlignment);
    scratchAddress += roundedUp(builds[i].scratch, alignment);
  }
  for (const auto& range : ranges) pointers.push_back(&range);
  const VkPipelineStageFlags build = VK_PIPELINE_STAGE_ACCELERATION_STRUCTURE_BUILD_BIT_KHR;
  const VkAccessFlags read = VK_ACCESS_ACCELERATION_STRUCTURE_READ_BIT_KHR,
                      write = VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
  device.run([&](VkCommandBuffer commands) {
    addBarrier(device, commands, VK_ACCESS_TRANSFER_WRITE_BIT | write, VK_PIPELINE_STAGE_TRANSFER_BIT | build,
               VK_ACCESS_SHADER_READ_BIT | read, build);
    device.vk.CmdBuildAccelerationStructuresKHR(commands, uint32_t(infos.size()), infos.data(), pointers.data());
    // also to shaders of the application, in any pipeline
    addBarrier(device, commands, write, build, read, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT);
  });
}

/* Builds in batches: the structures of a batch, and their scratch memory, have at most maxBatchBytes each, unless the
 * batch is a single structure. */
void buildAll(Device& device, std::vector<Build>& builds) {
  const size_t maxBatchBytes = std::min(size_t(64) << 20, device.capabilities.maxAllocation);
  for (Build& build : builds) build.measure(device);
  for (size_t first = 0; first < builds.size();) {
    size_t last = first, bytes = 0, scratch = 0;
    while (last < builds.size()) {
      bytes += roundedUp(builds[last].bytes, structureAlignment);
      scratch += roundedUp(builds[last].scratch, device.capabilities.scratchAlignment);
      if (last > first && std::max(bytes, scratch) > maxBatchBytes) break;
      last++;
    }
    buildTogether(device, &builds[first], last - first);
    first = last;
  }
}

} // namespace

BuildCounts buildBottomLevels(Device& device, std::vector<LevelRequest>& requests) {
  BuildCounts counts;
  std::vector<Build> builds;
  std::unordered_map<BoxesKey, size_t, HashOfKey> buildOf;
  for (LevelRequest& request : requests) {
    if (request.level || buildOf.count(request.key)) continue;
    if (request.key.boxes().size() > device.capabilities.maxBoxes)
      throw VulkanError(RTC_ERROR_INVALID_OPERATION,
                        "ray queries need a structure of " + std::to_string(request.key.boxes().size()) +
                            " boxes: expected at most " + std::to_string(device.capabilities.maxBoxes) +
                            ", the device's maxPrimitiveCount");
    Build build = Build();
    build.type = VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR;
    build.geometry = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    build.geometry.geometryType = VK_GEOMETRY_TYPE_AABBS_KHR;
    build.geometry.geometry.aabbs = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_AABBS_DATA_KHR};
    build.geometry.geometry.aabbs.data.deviceAddress = request.boxes;
    build.geometry.geometry.aabbs.stride = sizeof(VkAabbPositionsKHR);
    build.count = uint32_t(request.key.boxes().size());
    build.from = request.previous ? request.previous->structure->handle : VK_NULL_HANDLE;
    (build.from ? counts.updated : counts.built) += request.key.boxes().size();
    buildOf.insert({request.key, builds.size()});
    builds.push_back(build);
  }
  buildAll(device, builds);
  device.structures.removeExpired();
  std::vector<std::shared_ptr<const BottomLevel>> levels(builds.size());
  for (const auto& entry : buildOf) {
    levels[entry.second] =
        std::make_shared<const BottomLevel>(BottomLevel{entry.first, builds[entry.second].structure});
    device.structures.add(levels[entry.second]);
  }
  for (LevelRequest& request : requests)
    if (!request.level) request.level = levels[buildOf.at(request.key)];
  return counts;
}

std::shared_ptr<Structure> buildTopLevel(Device& device, VkDeviceAddress instances, size_t count) {
  std::vector<Build> builds(1, Build());
  Build& build = builds[0];
  build.type = VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR;
  build.geometry = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
  build.geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
  build.geometry.geometry.instances = {VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR};
  build.geometry.geometry.instances.data.deviceAddress = instances;
  build.count = uint32_t(count);
  buildAll(device, builds);
  return build.structure;
}

} // namespace embree::vulkan
