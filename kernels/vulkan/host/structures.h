// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vulkan acceleration structures for ray queries: bottom levels of boxes, which scenes share, and top levels. */

#include "boxes_key.h"
#include "functions.h"

#include <cstdint>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

namespace embree::vulkan {

class Buffer;
class Device;

/* An acceleration structure, in a buffer that it may share with others. */
class Structure {
public:
  /* Creates the handle. Does not build the structure. */
  Structure(Device& device, VkAccelerationStructureTypeKHR type, const std::shared_ptr<Buffer>& memory, size_t offset,
            size_t bytes);
  ~Structure();
  Structure(const Structure&) = delete;
  Structure& operator=(const Structure&) = delete;

  VkAccelerationStructureKHR handle = VK_NULL_HANDLE;
  VkDeviceAddress address = 0;
  const size_t bytes;

private:
  Device& device;
  const std::shared_ptr<Buffer> memory;
};

struct BottomLevel {
  BoxesKey key;
  std::shared_ptr<Structure> structure;
};

/* A device's bottom levels by their boxes, for reuse while a scene uses them. Thread-safe. */
class Structures {
public:
  std::shared_ptr<const BottomLevel> find(const BoxesKey& key) const; // Returns NULL if there is none.
  void add(const std::shared_ptr<const BottomLevel>& level);
  void removeExpired();

private:
  mutable std::mutex mutex;
  std::unordered_multimap<uint64_t, std::weak_ptr<const BottomLevel>> levels; // by hash of the key
};

struct LevelRequest {
  BoxesKey key;
  VkDeviceAddress boxes;                       // address of VkAabbPositionsKHR; not used if `level` is set
  std::shared_ptr<const BottomLevel> previous; // to update from, with the same number of boxes, or NULL
  std::shared_ptr<const BottomLevel> level;    // NULL until built
};

struct BuildCounts {
  size_t built = 0, updated = 0;
}; // numbers of boxes

/* Updates or builds the levels that are NULL, once per key, and adds them to the device. */
BuildCounts buildBottomLevels(Device& device, std::vector<LevelRequest>& requests);

/* instances: device address of VkAccelerationStructureInstanceKHR. */
std::shared_ptr<Structure> buildTopLevel(Device& device, VkDeviceAddress instances, size_t count);

} // namespace embree::vulkan
