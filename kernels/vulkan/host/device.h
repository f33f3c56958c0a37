// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* RTCVulkanDevice: an open Vulkan device with queue, command pool and pipelines. */

#include "opening.h"
#include "structures.h"
#include "uploads.h"

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <tuple>

namespace embree::vulkan {

enum Query { CLOSEST_HIT, ANY_HIT };

/* Base of objects with a reference count, which starts at 1. Thread-safe. */
class RefCounted {
public:
  void retain() { users++; }
  void release() {
    if (--users == 0) delete this;
  }

protected:
  virtual ~RefCounted() {}

private:
  std::atomic<size_t> users{1};
};

template<typename T>
class ScopedRef {
public:
  explicit ScopedRef(T& object) : object(object) { object.retain(); }
  ~ScopedRef() { object.release(); }
  ScopedRef(const ScopedRef&) = delete;
  ScopedRef& operator=(const ScopedRef&) = delete;

private:
  T& object;
};

/* Threads may call member functions concurrently. */
class Device : public RefCounted {
public:
  /* Opens a device. selector: see rtcNewVulkanDevice. */
  Device(RTCDevice embree, const char* selector);

  /* Uses a device that the application opened and continues to own. */
  Device(RTCDevice embree, const RTCVulkanDeviceHandles& applicationHandles);

  /* Submits the commands that record() records, and waits. record: see submit. */
  void run(const std::function<void(VkCommandBuffer)>& record);

  /* Commands that the device executes. The caller must pass each submission to waitAndFree. */
  struct Submission {
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
  };
  /* record() must not submit commands or compile pipelines, because the mutex is locked. */
  Submission submit(const std::function<void(VkCommandBuffer)>& record);
  void wait(const Submission& submission) const;
  bool isDone(const Submission& submission) const; // true also if the device failed

  /* Waits until a submission is done or the device is lost, and frees it. Never throws. */
  void waitAndFree(const Submission& submission);

  /* Pipeline of trace.comp, compiled on the first call with these arguments. kinds: Scene::kinds. stackSize: entries of
   * the traversal stack; ray queries have none. */
  VkPipeline pipeline(Query query, bool usesRayQuery, uint32_t kinds, uint32_t stackSize);
  VkPipelineLayout pipelineLayout() const { return layout; }

  /* The four pipelines of ray_order.comp, compiled on the first call. Throws if orderThreads exceeds a device limit. */
  const VkPipeline* makeOrderPipelines();

  const RTCDevice embree; // receives errors; retained, may be NULL
  RTCVulkanDeviceHandles handles;
  Capabilities capabilities;
  InstanceFunctions instanceFunctions;
  DeviceFunctions vk;
  Uploads uploads;
  Structures structures;

private:
  ~Device() override;
  void open();
  void readCache();
  void writeCache() const;
  void destroy();
  VkPipeline compile(const uint32_t* words, size_t bytes, const VkSpecializationInfo* specialization);
  std::string cachePath() const;
  static uint64_t checksum(const std::vector<char>& data);

  std::unique_ptr<VulkanInstance> vulkanInstance; // NULL if the application passed handles
  std::mutex mutex;                               // protects queue, command pool and pipelines
  VkCommandPool pool = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipelineCache cache = VK_NULL_HANDLE;
  size_t cacheBytes = 0; // size of the cache when it was read
  std::map<std::tuple<Query, bool, uint32_t, uint32_t>, VkPipeline> pipelines;
  VkPipeline orderPipelines[4] = {};
};

/* Push constants of trace.comp. order: pairs of ray_order.comp, or 0 if rays are not sorted. */
struct TraceArguments {
  VkDeviceAddress scene, rays, order;
  uint32_t first, count;
};

/* Push constants of ray_order.comp. */
struct OrderArguments {
  VkDeviceAddress rays, from, to, counts, scene;
  uint32_t count, rayWords, shift;
};

} // namespace embree::vulkan
