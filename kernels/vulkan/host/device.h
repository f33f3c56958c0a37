// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* An open Vulkan device with queue, command pool and pipelines. */

#include "opening.h"
#include "structures.h"
#include "uploads.h"

#include <atomic>
#include <functional>
#include <map>
#include <mutex>
#include <tuple>

namespace embree { namespace vulkan {

enum Query { CLOSEST_HIT, ANY_HIT };

/* Reference-counted, from 1. */
class Shared
{
public:
  void retain() { users++; }
  void release() { if (--users == 0) delete this; }

protected:
  virtual ~Shared() {}

private:
  std::atomic<size_t> users{1};
};

template<typename T>
class Held
{
public:
  explicit Held(T& object) : object(object) { object.retain(); }
  ~Held() { object.release(); }
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

private:
  T& object;
};

/* Threads may call member functions concurrently. */
class Device : public Shared
{
public:
  Device(RTCDevice embree, const char* which);
  Device(RTCDevice embree, const RTCVulkanHandles& handles);

  void run(const std::function<void(VkCommandBuffer)>& record);

  struct Submission
  {
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
  };
  Submission submit(const std::function<void(VkCommandBuffer)>& record);
  void wait(const Submission& submission) const;
  bool isDone(const Submission& submission) const;

  /* Frees a submission, after it is done or the device is lost. */
  void waitAndFree(const Submission& submission);

  /* Pipeline for scenes with these kinds of leaves, compiled on the first call. byQuery: ray queries instead of a stack
   * of stackSize entries. */
  VkPipeline pipeline(Query query, bool byQuery, uint32_t kinds, uint32_t stackSize);
  VkPipelineLayout pipelineLayout() const { return layout; }

  /* The four pipelines of ray_order.comp, compiled on the first call. */
  const VkPipeline* makeOrderPipelines();

  const RTCDevice embree;         // receives errors; retained, may be NULL
  RTCVulkanHandles handles;
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
  VkPipeline compile(const uint32_t* words, size_t bytes, const VkSpecializationInfo* special);
  std::string cachePath() const;
  static uint64_t checksum(const std::vector<char>& data);

  std::unique_ptr<VulkanInstance> vulkanInstance;  // NULL if the application passed handles
  std::mutex mutex;                  // protects queue, command pool and pipelines
  VkCommandPool pool = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipelineCache cache = VK_NULL_HANDLE;
  size_t cacheBytes = 0;             // size of the cache when it was read
  std::map<std::tuple<Query, bool, uint32_t, uint32_t>, VkPipeline> pipelines;
  VkPipeline orderPipelines[4] = {};
};

/* Push constants of trace.comp. order: 0 if rays are not sorted. */
struct TraceArguments
{
  VkDeviceAddress scene, rays, order;
  uint32_t first, count;
};

struct OrderArguments
{
  VkDeviceAddress rays, from, to, counts, scene;
  uint32_t count, rayWords, shift;
};

}} // namespace embree::vulkan
