// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* An open Vulkan device: its queue, one command at a time on it, and the pipelines that trace. */

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

/* Counts its users; made with one. */
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

/* Keeps something that is shared. */
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

class Device : public Shared
{
public:
  /* Throws VulkanError. */
  Device(RTCDevice embree, const char* which);
  Device(RTCDevice embree, const RTCVulkanHandles& handles);

  /* Records with the closure, submits and waits. */
  void run(const std::function<void(VkCommandBuffer)>& record);

  /* A command buffer that is submitted, and its fence. */
  struct Submission
  {
    VkCommandBuffer commands = VK_NULL_HANDLE;
    VkFence fence = VK_NULL_HANDLE;
  };
  Submission submit(const std::function<void(VkCommandBuffer)>& record);
  void wait(const Submission& submission) const;
  bool isDone(const Submission& submission) const;
  void recycle(const Submission& submission); // once it is done, or the device is lost: waits for that

  /* Pipeline for scenes of these kinds of leaves and a stack of so many entries, or that goes by ray queries; made when it is first asked for. */
  VkPipeline pipeline(Query query, bool byQuery, uint32_t kinds, uint32_t stackSize);
  VkPipelineLayout pipelineLayout() const { return layout; }

  /* Pipelines of the stages of ray_order.comp, made when they are first asked for. */
  const VkPipeline* makeOrderPipelines();

  const RTCDevice embree;         // gets errors; retained
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

  std::unique_ptr<Machine> machine;  // of a device that was opened here
  std::mutex mutex;                  // of the queue, the command pool and the pipelines
  VkCommandPool pool = VK_NULL_HANDLE;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkPipelineCache cache = VK_NULL_HANDLE;
  size_t cacheBytes = 0;             // when it was read
  std::map<std::tuple<Query, bool, uint32_t, uint32_t>, VkPipeline> pipelines;
  VkPipeline orderPipelines[4] = {};
};

/* Push constants of trace.comp. order: 0 for rays as they come. */
struct TraceArguments
{
  VkDeviceAddress scene, rays, order;
  uint32_t first, count;
};

/* Push constants of ray_order.comp. */
struct OrderArguments
{
  VkDeviceAddress rays, from, to, counts, scene;
  uint32_t count, rayWords, shift;
};

}} // namespace embree::vulkan
