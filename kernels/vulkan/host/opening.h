// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Finds the Vulkan loader, creates an instance, and chooses a physical device with the required features. */

#include "functions.h"
#include <embree3/rtcore_vulkan.h>

#include <cstdint>
#include <vector>

namespace embree::vulkan {

/* The Vulkan loader and an instance. The constructor throws VulkanError if there is no loader or no working
 * driver. */
class VulkanInstance {
public:
  VulkanInstance();
  ~VulkanInstance();
  VulkanInstance(const VulkanInstance&) = delete;
  VulkanInstance& operator=(const VulkanInstance&) = delete;

  std::vector<VkPhysicalDevice> devices() const; // in the order of rtcGetVulkanDevices

  PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
  VkInstance instance = VK_NULL_HANDLE;
  InstanceFunctions vk;

private:
  void* loader = nullptr;
};

/* Properties of a physical device. */
struct Capabilities {
  RTCVulkanDeviceInfo info;
  RTCError driverError = RTC_ERROR_NONE;   // set by examineDevice
  bool hasHostImport = false;              // the device has VK_EXT_external_memory_host
  size_t scratchAlignment = 256;           // of scratch memory for builds of acceleration structures, in bytes
  uint64_t maxBoxes = 0, maxInstances = 0; // of bottom-level and top-level acceleration structures
  uint32_t computeFamily = ~0u;            // index of a queue family that supports compute; ~0u if there is none
  VkPhysicalDeviceProperties properties;
  VkPhysicalDeviceMemoryProperties memory;
  size_t maxAllocation = 0;      // largest allocation, in bytes
  size_t importAlignment = 4096; // of host memory that is imported
  uint32_t timestampBits = 0;    // valid bits of the queue's timestamps; 0 without timestamps
  uint8_t cacheID[VK_UUID_SIZE]; // identifies the device and driver version of cached pipelines
};

/* Reads the properties of a device. If the device cannot be used, info.unsupportedReason contains the reason, and other
 * members may keep their defaults. Throws VulkanError if the driver fails. */
Capabilities capabilitiesOf(const InstanceFunctions& vk, VkPhysicalDevice device);

/* Same, but if the driver fails, sets info.name, info.unsupportedReason and driverError: a broken driver must not hide
 * other devices. */
Capabilities examineDevice(const InstanceFunctions& vk, VkPhysicalDevice device);

/* Throws VulkanError if no supported device fits. selector: see rtcNewVulkanDevice. */
VkPhysicalDevice chooseDevice(const VulkanInstance& vulkan, const std::string& selector);

/* Creates a device with one compute queue, the required features, and the optional ones that it supports. */
VkDevice createDevice(const InstanceFunctions& vk, VkPhysicalDevice device, const Capabilities& capabilities);

} // namespace embree::vulkan
