// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A committed scene on a device. */

#include "blocks.h"
#include "query_structures.h"
#include "tree.h"
#include "../scene_layout.h"

namespace embree { namespace vulkan {

struct SceneOptions
{
  RTCVulkanMemory memory = RTC_VULKAN_MEMORY_AUTO;
  bool byQuery = false;
  class Scene* previous = nullptr;   // see RTCVulkanSceneArguments
};

class Scene : public Shared
{
public:
  /* Throws VulkanError that names the geometry, or the limit. */
  Scene(Device& device, RTCScene scene, const SceneOptions& options);

  Device& device;
  const Held<Device> held;   // goes last
  VkDeviceAddress address = 0;
  uint32_t kinds = 0;
  const bool byQuery;
  RTCVulkanSceneStatistics statistics{};

  /* Records the trace of rays at an address. order: of recordRayOrder, or 0. */
  void record(Query query, VkPipeline pipeline, VkCommandBuffer commands, VkDeviceAddress rays, size_t count, VkDeviceAddress order = 0) const;

  std::atomic<bool> sortsRays{false};   // of the host

  /* of a scene for ray queries */
  const QueryStructures& queryStructures() const { return structures; }

private:
  ~Scene() override;

  friend class SceneUpload;
  RTCScene source = nullptr;   // retained where its memory is used
  QueryStructures structures;
  Arena arena;
  BlockBuffers blocks;
};

}} // namespace embree::vulkan
