// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A Vulkan device that libembree3_vulkan opened, with our own commands and buffers, as in a renderer that calls Vulkan
 * through volk. */

#include "building/embree_device.h"

#include <volk.h>

#include <embree3/rtcore_vulkan.h>

#include <functional>
#include <string>

namespace cbvh {

/* Throws Error that names the operation `doing` if the result is an error. */
void checkVulkan(VkResult result, const std::string& doing);

class VulkanDevice
{
public:
  /* `which` is an argument of rtcNewVulkanDevice. At most one may exist, because volk supports one. Throws Error. */
  explicit VulkanDevice(const std::string& which);
  ~VulkanDevice();
  VulkanDevice(const VulkanDevice&) = delete;
  VulkanDevice& operator=(const VulkanDevice&) = delete;

  /* Throws Error if a function of rtcore_vulkan.h failed since the last call. */
  void check(const char* doing) { errors.check(doing); }

  RTCVulkanDevice handle() const { return device; }
  std::string name() const; // names of the device and its driver

  /* Records commands with `record`, submits them, and waits. Throws Error. */
  void run(const std::function<void(VkCommandBuffer)>& record) const;

  RTCVulkanHandles vk{};

private:
  EmbreeDevice errors; // receives errors of the library; destroyed last
  RTCVulkanDevice device = nullptr;
  VkCommandPool pool = VK_NULL_HANDLE;
};

/* A buffer and its memory. */
class VulkanBuffer
{
public:
  enum Kind
  {
    OnDevice, // with an address for shaders
    ToRead    // readable and coherent for the host
  };

  /* Allocates the buffer. Throws Error. */
  VulkanBuffer(const VulkanDevice& device, VkDeviceSize bytes, Kind kind);
  ~VulkanBuffer() { destroy(); }
  VulkanBuffer(const VulkanBuffer&) = delete;
  VulkanBuffer& operator=(const VulkanBuffer&) = delete;

  VkBuffer handle = VK_NULL_HANDLE;
  VkDeviceAddress address = 0;  // for OnDevice
  const void* mapped = nullptr; // for ToRead
  const VkDeviceSize bytes;

private:
  void create(Kind kind);
  void allocate(Kind kind);
  void destroy();

  const VulkanDevice& device;
  VkDeviceMemory memory = VK_NULL_HANDLE;
};

} // namespace cbvh
