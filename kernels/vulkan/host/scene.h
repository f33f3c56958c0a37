// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* RTCVulkanScene: a committed scene on a device. */

#include "blocks.h"
#include "query_structures.h"
#include "tree.h"
#include "../scene_layout.h"

namespace embree::vulkan {

struct SceneOptions {
  RTCVulkanMemory memory = RTC_VULKAN_MEMORY_AUTO;
  bool usesRayQuery = false;            // trace by ray queries
  class Scene* previousScene = nullptr; // scene before an edit, to update acceleration structures from, or NULL
};

class Scene : public RefCounted {
public:
  /* Throws VulkanError naming the unsupported geometry or the exceeded limit. */
  Scene(Device& device, RTCScene scene, const SceneOptions& options);

  Device& device;
  const ScopedRef<Device> held; // declared before the buffers, which it must outlive
  VkDeviceAddress address = 0;  // device address of SceneData
  uint32_t kinds = 0;           // mask of the types of references in the scene, without nodeReferenceType; runs of all
                                // lengths set the bit of firstRunReferenceType
  const bool usesRayQuery;
  RTCVulkanSceneStatistics statistics{};

  /* Records the trace of `count` rays, without barriers. pipeline: from Device::pipeline. rays: device address of
   * RTCRayHit (CLOSEST_HIT) or RTCRay. order: scratch of recordRayOrder, or 0. */
  void record(Query query, VkPipeline pipeline, VkCommandBuffer commands, VkDeviceAddress rays, size_t count,
              VkDeviceAddress order = 0) const;

  std::atomic<bool> sortsRays{false}; // see rtcSetVulkanSceneRaySorting

  const QueryStructures& queryStructures() const { return structures; } // empty unless usesRayQuery

private:
  ~Scene() override;

  friend class SceneUpload;
  RTCScene source = nullptr; // retained if its memory was imported, else NULL
  QueryStructures structures;
  Arena arena;
  BlockBuffers blocks;
};

} // namespace embree::vulkan
