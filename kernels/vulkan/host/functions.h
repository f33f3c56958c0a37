// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vulkan's functions, loaded per instance and device: an application may have several of each, and its own loader. */

#include "error.h"

#include <vulkan/vulkan_core.h>

namespace embree::vulkan {

// clang-format off
#define CBVH_INSTANCE_FUNCTIONS(F) \
  F(DestroyInstance) F(EnumeratePhysicalDevices) F(GetPhysicalDeviceProperties) F(GetPhysicalDeviceProperties2) \
  F(GetPhysicalDeviceFeatures2) F(GetPhysicalDeviceMemoryProperties) F(GetPhysicalDeviceQueueFamilyProperties) \
  F(EnumerateDeviceExtensionProperties) F(CreateDevice) F(GetDeviceProcAddr)

#define CBVH_DEVICE_FUNCTIONS(F) \
  F(DestroyDevice) F(GetDeviceQueue) F(QueueSubmit) \
  F(CreateBuffer) F(DestroyBuffer) F(GetBufferMemoryRequirements) F(BindBufferMemory) F(GetBufferDeviceAddress) \
  F(AllocateMemory) F(FreeMemory) F(MapMemory) \
  F(CreateShaderModule) F(DestroyShaderModule) F(CreatePipelineLayout) F(DestroyPipelineLayout) \
  F(CreateComputePipelines) F(DestroyPipeline) F(CreatePipelineCache) F(DestroyPipelineCache) F(GetPipelineCacheData) \
  F(CreateCommandPool) F(DestroyCommandPool) F(AllocateCommandBuffers) F(FreeCommandBuffers) \
  F(BeginCommandBuffer) F(EndCommandBuffer) F(CmdBindPipeline) F(CmdPushConstants) F(CmdDispatch) \
  F(CmdPipelineBarrier) F(CmdCopyBuffer) F(CmdWriteTimestamp) F(CmdResetQueryPool) \
  F(CreateQueryPool) F(DestroyQueryPool) F(GetQueryPoolResults) \
  F(CreateFence) F(DestroyFence) F(WaitForFences) F(GetFenceStatus)

/* NULL if constructed without hasRayQuery. */
#define CBVH_STRUCTURE_FUNCTIONS(F) \
  F(CreateAccelerationStructureKHR) F(DestroyAccelerationStructureKHR) F(GetAccelerationStructureBuildSizesKHR) \
  F(GetAccelerationStructureDeviceAddressKHR) F(CmdBuildAccelerationStructuresKHR)
// clang-format on

#define CBVH_DECLARE(NAME) PFN_vk##NAME NAME = nullptr;

struct InstanceFunctions {
  CBVH_INSTANCE_FUNCTIONS(CBVH_DECLARE)

  InstanceFunctions() = default;

  /* Throws VulkanError naming a missing function. */
  InstanceFunctions(PFN_vkGetInstanceProcAddr getInstanceProcAddr, VkInstance instance) {
#define CBVH_LOAD(NAME) \
  NAME = PFN_vk##NAME(getInstanceProcAddr(instance, "vk" #NAME)); \
  check(PFN_vkVoidFunction(NAME), "vk" #NAME);
    CBVH_INSTANCE_FUNCTIONS(CBVH_LOAD)
#undef CBVH_LOAD
  }

  static constexpr const char* vulkan12 = "Vulkan 1.2 is needed";

  /* needed: ends the message. */
  static void check(PFN_vkVoidFunction function, const char* name, const char* needed = vulkan12) {
    if (!function)
      throw VulkanError(RTC_ERROR_INVALID_OPERATION,
                        std::string("Vulkan's loader or driver has no ") + name + ": " + needed);
  }
};

struct DeviceFunctions {
  CBVH_DEVICE_FUNCTIONS(CBVH_DECLARE)
  CBVH_STRUCTURE_FUNCTIONS(CBVH_DECLARE)
  /* NULL if constructed without hasHostImport. */
  PFN_vkGetMemoryHostPointerPropertiesEXT GetMemoryHostPointerPropertiesEXT = nullptr;

  DeviceFunctions() = default;

  DeviceFunctions(PFN_vkGetDeviceProcAddr getDeviceProcAddr, VkDevice device, bool hasHostImport, bool hasRayQuery) {
#define CBVH_LOAD(NAME) \
  NAME = PFN_vk##NAME(getDeviceProcAddr(device, "vk" #NAME)); \
  InstanceFunctions::check(PFN_vkVoidFunction(NAME), "vk" #NAME, needed);
    const char* needed = InstanceFunctions::vulkan12;
    CBVH_DEVICE_FUNCTIONS(CBVH_LOAD)
    needed = "hasRayQuery requires a device with VK_KHR_acceleration_structure enabled";
    if (hasRayQuery) { CBVH_STRUCTURE_FUNCTIONS(CBVH_LOAD) }
    needed = "hasHostImport requires a device with VK_EXT_external_memory_host enabled";
    if (hasHostImport) { CBVH_LOAD(GetMemoryHostPointerPropertiesEXT) }
#undef CBVH_LOAD
  }
};

#undef CBVH_DECLARE

/* Throws VulkanError if `result` is an error. doing: for the message, for example "creating a fence". */
void check(VkResult result, const std::string& doing);

} // namespace embree::vulkan
