// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A Vulkan device that libembree3_vulkan opened, used as by a renderer that calls Vulkan through volk. */

#include "building/embree_device.h"

#include <volk.h>

#include <embree3/rtcore_vulkan.h>

#include <functional>
#include <string>

namespace programs {

/* Throws Error with `operation` if the result is an error. */
void checkVulkan(VkResult result, const std::string& operation);

class VulkanDevice {
public:
  /* `selector` is for rtcNewVulkanDevice. Only one may exist, because volk supports one. Throws Error. */
  explicit VulkanDevice(const std::string& selector);
  ~VulkanDevice();
  VulkanDevice(const VulkanDevice&) = delete;
  VulkanDevice& operator=(const VulkanDevice&) = delete;

  /* Throws Error after a failure of rtcore_vulkan.h since the last call. */
  void check(const char* operation) { errors.check(operation); }

  RTCVulkanDevice handle() const { return device; }
  std::string name() const; // device and driver

  /* Submits the commands of `record` and waits. Throws Error. */
  void run(const std::function<void(VkCommandBuffer)>& record) const;

  RTCVulkanDeviceHandles vk{};

private:
  EmbreeDevice errors; // of the library; destroyed last
  RTCVulkanDevice device = nullptr;
  VkCommandPool pool = VK_NULL_HANDLE;
};

class VulkanBuffer {
public:
  enum Kind {
    DeviceLocal, // has an address for shaders
    HostReadable // also coherent
  };

  /* The device must outlive the buffer. Throws Error. */
  VulkanBuffer(const VulkanDevice& device, VkDeviceSize bytes, Kind kind);
  ~VulkanBuffer() { destroy(); }
  VulkanBuffer(const VulkanBuffer&) = delete;
  VulkanBuffer& operator=(const VulkanBuffer&) = delete;

  VkBuffer handle = VK_NULL_HANDLE;
  VkDeviceAddress address = 0;  // for DeviceLocal
  const void* mapped = nullptr; // for HostReadable
  const VkDeviceSize bytes;

private:
  void create(Kind kind);
  void allocate(Kind kind);
  void destroy();

  const VulkanDevice& device;
  VkDeviceMemory memory = VK_NULL_HANDLE;
};

} // namespace programs
