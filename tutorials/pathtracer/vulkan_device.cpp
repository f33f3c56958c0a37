// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#define VOLK_IMPLEMENTATION
#include "vulkan_device.h"
#include "basics/error.h"

#include <cstdint>

namespace programs {
namespace {

std::string nameOf(VkResult result) {
  switch (result) {
  case VK_ERROR_OUT_OF_HOST_MEMORY: return "out of host memory";
  case VK_ERROR_OUT_OF_DEVICE_MEMORY: return "out of device memory";
  case VK_ERROR_DEVICE_LOST: return "the device is lost";
  default: return "VkResult " + std::to_string(result);
  }
}

/* Preferred properties are optional. */
uint32_t memoryType(VkPhysicalDevice device, uint32_t allowed, VkMemoryPropertyFlags needed,
                    VkMemoryPropertyFlags preferred) {
  VkPhysicalDeviceMemoryProperties properties;
  vkGetPhysicalDeviceMemoryProperties(device, &properties);
  for (VkMemoryPropertyFlags flags : {needed | preferred, needed})
    for (uint32_t i = 0; i < properties.memoryTypeCount; i++)
      if ((allowed & (1u << i)) && (properties.memoryTypes[i].propertyFlags & flags) == flags) return i;
  throw Error("allocating a picture: the Vulkan device has no memory of the required type");
}

} // namespace

void checkVulkan(VkResult result, const std::string& operation) {
  if (result < VK_SUCCESS) throw Error("Vulkan, " + operation + ": " + nameOf(result));
}

/* --- device ------------------------------------------------------------------------------- */

VulkanDevice::VulkanDevice(const std::string& selector) : errors("") {
  device = rtcNewVulkanDevice(errors.handle(), selector.c_str());
  check("opening a Vulkan device");
  rtcGetVulkanDeviceHandles(device, &vk);
  volkInitializeCustom(vk.getInstanceProcAddr);
  volkLoadInstance(vk.instance);
  volkLoadDevice(vk.device);
  VkCommandPoolCreateInfo info = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  info.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  info.queueFamilyIndex = vk.queueFamily;
  const VkResult result = vkCreateCommandPool(vk.device, &info, nullptr, &pool);
  if (result < VK_SUCCESS) rtcReleaseVulkanDevice(device);
  checkVulkan(result, "creating a command pool");
}

VulkanDevice::~VulkanDevice() {
  vkDestroyCommandPool(vk.device, pool, nullptr);
  rtcReleaseVulkanDevice(device);
}

std::string VulkanDevice::name() const {
  RTCVulkanDeviceInfo info;
  rtcGetVulkanDeviceInfo(device, &info);
  return std::string(info.name) + ", " + info.driver;
}

void VulkanDevice::run(const std::function<void(VkCommandBuffer)>& record) const {
  checkVulkan(vkResetCommandPool(vk.device, pool, VK_COMMAND_POOL_RESET_RELEASE_RESOURCES_BIT), "resetting commands");
  VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  checkVulkan(vkAllocateCommandBuffers(vk.device, &allocate, &commands), "allocating commands");
  VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  VkResult result = vkBeginCommandBuffer(commands, &begin);
  if (result >= VK_SUCCESS) {
    record(commands);
    result = vkEndCommandBuffer(commands);
  }
  VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
  submit.commandBufferCount = 1;
  submit.pCommandBuffers = &commands;
  if (result >= VK_SUCCESS) result = vkQueueSubmit(vk.queue, 1, &submit, VK_NULL_HANDLE);
  if (result >= VK_SUCCESS) result = vkQueueWaitIdle(vk.queue);
  vkFreeCommandBuffers(vk.device, pool, 1, &commands);
  checkVulkan(result, "running commands");
}

/* --- buffer ------------------------------------------------------------------------------- */

VulkanBuffer::VulkanBuffer(const VulkanDevice& device, VkDeviceSize bytes, Kind kind) : bytes(bytes), device(device) {
  try {
    create(kind);
    allocate(kind);
  } catch (...) {
    destroy();
    throw;
  }
}

void VulkanBuffer::create(Kind kind) {
  VkBufferCreateInfo info = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
  info.size = bytes;
  info.usage = kind == HostReadable ? VK_BUFFER_USAGE_TRANSFER_DST_BIT
                                    : VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                          VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT;
  checkVulkan(vkCreateBuffer(device.vk.device, &info, nullptr, &handle), "creating a buffer");
}

void VulkanBuffer::allocate(Kind kind) {
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(device.vk.device, handle, &requirements);
  VkMemoryAllocateFlagsInfo flags = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo info = {VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO};
  info.allocationSize = requirements.size;
  if (kind == HostReadable)
    info.memoryTypeIndex = memoryType(device.vk.physicalDevice, requirements.memoryTypeBits,
                                      VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT,
                                      VK_MEMORY_PROPERTY_HOST_CACHED_BIT);
  else {
    info.memoryTypeIndex =
        memoryType(device.vk.physicalDevice, requirements.memoryTypeBits, 0, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    info.pNext = &flags;
  }
  checkVulkan(vkAllocateMemory(device.vk.device, &info, nullptr, &memory),
              "allocating " + std::to_string(requirements.size) + " bytes for a picture");
  checkVulkan(vkBindBufferMemory(device.vk.device, handle, memory, 0), "binding memory");
  if (kind == DeviceLocal) {
    VkBufferDeviceAddressInfo addressInfo = {VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
    addressInfo.buffer = handle;
    address = vkGetBufferDeviceAddress(device.vk.device, &addressInfo);
    return;
  }
  void* data = nullptr;
  checkVulkan(vkMapMemory(device.vk.device, memory, 0, VK_WHOLE_SIZE, 0, &data), "mapping memory");
  mapped = data;
}

void VulkanBuffer::destroy() {
  vkDestroyBuffer(device.vk.device, handle, nullptr);
  vkFreeMemory(device.vk.device, memory, nullptr); // also unmaps
}

} // namespace programs
