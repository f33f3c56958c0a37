// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A buffer of rays and a command buffer of the application. */

#include <embree3/rtcore_vulkan.h>

#include <functional>

namespace programs::test {

// Host-visible memory with a device address.
class RayBuffer {
public:
  // Throws std::runtime_error with the name of the failed call.
  // data: may be NULL; usage: in addition to storage, address and copies
  RayBuffer(const RTCVulkanDeviceHandles& handles, const void* data, size_t bytes, VkBufferUsageFlags usage = 0);
  ~RayBuffer();
  RayBuffer(const RayBuffer&) = delete;
  RayBuffer& operator=(const RayBuffer&) = delete;

  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceAddress address = 0;
  void* mapped = nullptr;

private:
  const RTCVulkanDeviceHandles handles;
  VkDeviceMemory memory = VK_NULL_HANDLE;
};

// A command buffer that is recorded once.
class RecordedTrace {
public:
  explicit RecordedTrace(const RTCVulkanDeviceHandles& handles);
  ~RecordedTrace();
  RecordedTrace(const RecordedTrace&) = delete;
  RecordedTrace& operator=(const RecordedTrace&) = delete;

  // Adds the host barriers that the API requires from the caller.
  void record(const std::function<void(VkCommandBuffer)>& commands);
  void submitAndWait();

  // Does not record barriers.
  static void copy(VkCommandBuffer commands, const RayBuffer& from, const RayBuffer& to, size_t bytes);

private:
  const RTCVulkanDeviceHandles handles;
  VkCommandPool pool = VK_NULL_HANDLE;
  VkCommandBuffer commands = VK_NULL_HANDLE;
};

} // namespace programs::test
