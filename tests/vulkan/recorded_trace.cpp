// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "recorded_trace.h"

#include <vulkan/vulkan.h>

#include <cstring>
#include <stdexcept>
#include <string>

namespace programs::test {
namespace {

void check(VkResult result, const char* doing) {
  if (result != VK_SUCCESS)
    throw std::runtime_error(std::string(doing) + " failed: VkResult " + std::to_string(result));
}

} // namespace

RayBuffer::RayBuffer(const RTCVulkanDeviceHandles& handles, const void* data, size_t bytes, VkBufferUsageFlags usage)
  : handles(handles) {
  VkBufferCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = bytes;
  info.usage = usage | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
               VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
  check(vkCreateBuffer(handles.device, &info, nullptr, &buffer), "vkCreateBuffer");
  VkMemoryRequirements requirements;
  vkGetBufferMemoryRequirements(handles.device, buffer, &requirements);
  VkPhysicalDeviceMemoryProperties types;
  vkGetPhysicalDeviceMemoryProperties(handles.physicalDevice, &types);
  const VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  VkMemoryAllocateFlagsInfo flags = {};
  flags.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO;
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo allocation = {};
  allocation.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  allocation.pNext = &flags;
  allocation.allocationSize = requirements.size;
  while (!(requirements.memoryTypeBits & (1u << allocation.memoryTypeIndex)) ||
         (types.memoryTypes[allocation.memoryTypeIndex].propertyFlags & host) != host)
    if (++allocation.memoryTypeIndex == types.memoryTypeCount) throw std::runtime_error("no host-visible memory");
  check(vkAllocateMemory(handles.device, &allocation, nullptr, &memory), "vkAllocateMemory");
  check(vkBindBufferMemory(handles.device, buffer, memory, 0), "vkBindBufferMemory");
  check(vkMapMemory(handles.device, memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
  if (data) std::memcpy(mapped, data, bytes);
  VkBufferDeviceAddressInfo addressInfo = {};
  addressInfo.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO;
  addressInfo.buffer = buffer;
  address = vkGetBufferDeviceAddress(handles.device, &addressInfo);
}

RayBuffer::~RayBuffer() {
  vkDestroyBuffer(handles.device, buffer, nullptr);
  vkFreeMemory(handles.device, memory, nullptr);
}

RecordedTrace::RecordedTrace(const RTCVulkanDeviceHandles& handles) : handles(handles) {
  VkCommandPoolCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  info.queueFamilyIndex = handles.queueFamily;
  check(vkCreateCommandPool(handles.device, &info, nullptr, &pool), "vkCreateCommandPool");
  VkCommandBufferAllocateInfo allocation = {};
  allocation.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  allocation.commandPool = pool;
  allocation.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocation.commandBufferCount = 1;
  check(vkAllocateCommandBuffers(handles.device, &allocation, &commands), "vkAllocateCommandBuffers");
}

RecordedTrace::~RecordedTrace() { vkDestroyCommandPool(handles.device, pool, nullptr); }

void RecordedTrace::record(const std::function<void(VkCommandBuffer)>& trace) {
  VkCommandBufferBeginInfo begin = {};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
  trace(commands);
  VkMemoryBarrier barrier = {};
  barrier.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER;
  barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
  barrier.dstAccessMask = VK_ACCESS_HOST_READ_BIT;
  vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0,
                       nullptr, 0, nullptr);
  check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");
}

void RecordedTrace::submitAndWait() {
  VkSubmitInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO;
  info.commandBufferCount = 1;
  info.pCommandBuffers = &commands;
  check(vkQueueSubmit(handles.queue, 1, &info, VK_NULL_HANDLE), "vkQueueSubmit");
  check(vkQueueWaitIdle(handles.queue), "vkQueueWaitIdle");
}

void RecordedTrace::copy(VkCommandBuffer commands, const RayBuffer& from, const RayBuffer& to, size_t bytes) {
  const VkBufferCopy all = {0, 0, bytes};
  vkCmdCopyBuffer(commands, from.buffer, to.buffer, 1, &all);
}

} // namespace programs::test
