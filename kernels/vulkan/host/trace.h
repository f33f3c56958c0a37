// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays of the host, traced on a device. */

#include "scene.h"

namespace embree { namespace vulkan {

class Trace
{
public:
  /* Starts. Throws VulkanError. */
  Trace(Scene& scene, Query query, const void* rays, size_t count);
  ~Trace();
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;

  bool isDone() const { return device.isDone(submission); }

  /* Waits; writes rays and times unless NULL. Throws VulkanError. */
  void finish(void* rays, RTCVulkanTimes* times);

  Device& device;

private:
  void record(VkCommandBuffer commands, VkPipeline pipeline, const VkPipeline* sorting);
  RTCVulkanTimes readTimes() const;

  const Held<Scene> held;
  Scene& scene;
  const Query query;
  const size_t count, bytes;
  std::unique_ptr<Buffer> staging, onDevice;   // staging: unless the host sees the device's
  std::unique_ptr<Buffer> order;               // of rays that are sorted
  VkQueryPool clock = VK_NULL_HANDLE;
  Device::Submission submission;
};

}} // namespace embree::vulkan
