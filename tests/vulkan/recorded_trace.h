// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* An application's own buffer of rays and its own commands. */

#include <embree3/rtcore_vulkan.h>

#include <functional>

namespace cbvh::test {

// Memory with an address that the host sees.
class RayBuffer
{
public:
  // Throws std::runtime_error with what failed.
  // data: may be NULL; usage: besides storage, address and copies
  RayBuffer(const RTCVulkanHandles& handles, const void* data, size_t bytes, VkBufferUsageFlags usage = 0);
  ~RayBuffer();
  RayBuffer(const RayBuffer&) = delete;
  RayBuffer& operator=(const RayBuffer&) = delete;

  VkBuffer buffer = VK_NULL_HANDLE;
  VkDeviceAddress address = 0;
  void* mapped = nullptr;

private:
  const RTCVulkanHandles handles;
  VkDeviceMemory memory = VK_NULL_HANDLE;
};

// One command buffer, recorded once.
class RecordedTrace
{
public:
  explicit RecordedTrace(const RTCVulkanHandles& handles);
  ~RecordedTrace();
  RecordedTrace(const RecordedTrace&) = delete;
  RecordedTrace& operator=(const RecordedTrace&) = delete;

  // With the barriers to the host around it that are the caller's.
  void record(const std::function<void(VkCommandBuffer)>& commands);
  void submitAndWait();

  // Without barriers.
  static void copy(VkCommandBuffer commands, const RayBuffer& from, const RayBuffer& to, size_t bytes);

private:
  const RTCVulkanHandles handles;
  VkCommandPool pool = VK_NULL_HANDLE;
  VkCommandBuffer commands = VK_NULL_HANDLE;
};

} // namespace cbvh::test
