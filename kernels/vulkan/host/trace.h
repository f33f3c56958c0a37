// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* RTCVulkanTrace: traces rays in host memory asynchronously. */

#include "scene.h"

namespace embree::vulkan {

/* The destructor waits for the device. */
class Trace {
public:
  /* Copies the rays and submits the trace. */
  Trace(Scene& scene, Query query, const void* rays, size_t count);
  ~Trace();
  Trace(const Trace&) = delete;
  Trace& operator=(const Trace&) = delete;

  bool isDone() const { return device.isDone(submission); }

  /* Waits, then writes the rays with their hits, and the times (0 without timestamps). Both may be NULL. If the device
   * failed, throws VulkanError and writes nothing. */
  void finish(void* rays, RTCVulkanTraceTimes* times);

  Device& device;

private:
  void record(VkCommandBuffer commands, VkPipeline pipeline, const VkPipeline* orderPipelines);
  RTCVulkanTraceTimes readTimes() const;

  const ScopedRef<Scene> held;
  Scene& scene;
  const Query query;
  const size_t count, bytes;
  std::unique_ptr<Buffer> staging, onDevice; // staging is NULL without rays, or if onDevice is mapped
  std::unique_ptr<Buffer> order;             // scratch of the sort; NULL without sorting
  VkQueryPool queryPool = VK_NULL_HANDLE;    // timestamps; null if the queue does not support them
  Device::Submission submission;
};

} // namespace embree::vulkan
