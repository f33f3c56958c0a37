// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A Vulkan device that libembree3_vulkan opened, for commands and buffers of our own beside its: here
 * as a renderer would have it, which calls Vulkan through volk. */

#include "building/embree_device.h"

#include <volk.h>

#include <embree3/rtcore_vulkan.h>

#include <functional>
#include <string>

namespace cbvh {

/* Throws Error that says what was done unless it went well. */
void checkVulkan(VkResult result, const std::string& doing);

class VulkanDevice
{
public:
  /* which: as rtcNewVulkanDevice takes it. One at a time: volk's functions are of one device. Throws Error. */
  explicit VulkanDevice(const std::string& which);
  ~VulkanDevice();
  VulkanDevice(const VulkanDevice&) = delete;
  VulkanDevice& operator=(const VulkanDevice&) = delete;

  /* Throws Error if a function of rtcore_vulkan.h failed since the last call. */
  void check(const char* doing) { errors.check(doing); }

  RTCVulkanDevice handle() const { return device; }
  std::string name() const; // the device's and its driver's

  /* Records commands with the closure, submits them, and waits. Throws Error. */
  void run(const std::function<void(VkCommandBuffer)>& record) const;

  RTCVulkanHandles vk{};

private:
  EmbreeDevice errors; // gets those of the library; goes last
  RTCVulkanDevice device = nullptr;
  VkCommandPool pool = VK_NULL_HANDLE;
};

/* A buffer and its memory. */
class VulkanBuffer
{
public:
  enum Kind
  {
    OnDevice, // has an address for shaders
    ToRead    // by the host, coherently
  };

  /* Throws Error. */
  VulkanBuffer(const VulkanDevice& device, VkDeviceSize bytes, Kind kind);
  ~VulkanBuffer() { destroy(); }
  VulkanBuffer(const VulkanBuffer&) = delete;
  VulkanBuffer& operator=(const VulkanBuffer&) = delete;

  VkBuffer handle = VK_NULL_HANDLE;
  VkDeviceAddress address = 0;  // of OnDevice
  const void* mapped = nullptr; // of ToRead
  const VkDeviceSize bytes;

private:
  void create(Kind kind);
  void allocate(Kind kind);
  void destroy();

  const VulkanDevice& device;
  VkDeviceMemory memory = VK_NULL_HANDLE;
};

} // namespace cbvh
