// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The driver's structures for ray queries: bottom levels of boxes, which scenes share, and a top level. */

#include "functions.h"

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

namespace embree { namespace vulkan {

class Arena;
class Buffer;
class Device;
class Uploader;

/* A structure of the driver's, in a buffer that others may lie in, too. */
class Structure
{
public:
  /* Not built yet. Throws VulkanError. */
  Structure(Device& device, VkAccelerationStructureTypeKHR type, const std::shared_ptr<Buffer>& memory, size_t offset, size_t bytes);
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

/* What a bottom level is known by: how many boxes it has, and a sum over them. */
struct BoxesKey
{
  uint64_t count, sum;
  bool operator<(const BoxesKey& other) const { return count < other.count || (count == other.count && sum < other.sum); }
};

struct BottomLevel
{
  BoxesKey key;
  std::shared_ptr<Structure> structure;
};

/* The bottom levels that a device has, for scenes that come later. */
class Structures
{
public:
  std::shared_ptr<const BottomLevel> find(const BoxesKey& key) const;
  void add(const std::shared_ptr<const BottomLevel>& level);
  void clean();   // forgets those that no scene has any more

private:
  mutable std::mutex mutex;
  std::map<BoxesKey, std::weak_ptr<const BottomLevel>> levels;
};

/* A bottom level that a scene needs. */
struct WantedLevel
{
  BoxesKey key;
  VkDeviceAddress boxes;                               // VkAabbPositionsKHR each
  std::shared_ptr<const BottomLevel> previous;         // of as many boxes, to update; or NULL
  std::shared_ptr<const BottomLevel> level;            // where the device has it; else set by buildBottomLevels
};

struct BuildCounts { size_t built = 0, updated = 0; }; // boxes

/* Updates or builds those that there are not. Boxes are on the device. Throws VulkanError. */
BuildCounts buildBottomLevels(Device& device, std::vector<WantedLevel>& wanted);

/* Builds. instances: their address on the device. */
std::shared_ptr<Structure> buildTopLevel(Device& device, VkDeviceAddress instances, size_t count);

}} // namespace embree::vulkan
