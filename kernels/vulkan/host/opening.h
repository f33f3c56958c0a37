// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Finding and opening Vulkan devices: loader, instance, choice of a device, its features. */

#include "functions.h"
#include <embree3/rtcore_vulkan.h>

#include <cstdint>
#include <memory>
#include <vector>

namespace embree { namespace vulkan {

/* The machine's Vulkan: its loader and an instance. Throws VulkanError if there is none. */
class Machine
{
public:
  Machine();
  ~Machine();
  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  std::vector<VkPhysicalDevice> devices() const;

  PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
  VkInstance instance = VK_NULL_HANDLE;
  InstanceFunctions vk;

private:
  void* loader = nullptr;
};

/* What of a physical device matters here. */
struct Capabilities
{
  RTCVulkanDeviceInfo info;
  bool hasHostImport = false;
  size_t scratchAlignment = 256;    // of builds of structures for ray queries
  uint64_t maxBoxes = 0, maxInstances = 0;
  uint32_t computeFamily = ~0u;
  VkPhysicalDeviceProperties properties;
  VkPhysicalDeviceMemoryProperties memory;
  size_t maxAllocation = 0;         // bytes of a memory allocation
  size_t importAlignment = 4096;
  uint32_t timestampBits = 0;       // of the compute family
  uint8_t cacheID[VK_UUID_SIZE];
};

Capabilities capabilitiesOf(const InstanceFunctions& vk, VkPhysicalDevice device);

/* Device that `which` means, see rtcNewVulkanDevice. Throws VulkanError. */
VkPhysicalDevice chooseDevice(const Machine& machine, const std::string& which);

/* With what tracing needs enabled. Throws VulkanError. */
VkDevice createDevice(const InstanceFunctions& vk, VkPhysicalDevice device, const Capabilities& capabilities);

}} // namespace embree::vulkan
