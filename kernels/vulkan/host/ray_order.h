// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Sorts ray indices on the device, so that neighboring threads visit the same blocks. */

#include "scene.h"

namespace embree { namespace vulkan {

/* Scratch memory for `count` rays. Throws VulkanError for too many. */
size_t rayOrderBytes(size_t count);

struct RaysToOrder
{
  VkDeviceAddress rays;
  size_t rayBytes, count;
  VkDeviceAddress scratch;   // of rayOrderBytes(count), aligned to 16
};

/* Records the sort and a barrier after its last write. Sorted pairs (key, index) are at the beginning of scratch.
 * pipelines: from Device::makeOrderPipelines. Throws before it records anything. */
void recordRayOrder(const Scene& scene, const VkPipeline* pipelines, VkCommandBuffer commands, const RaysToOrder& rays);

}} // namespace embree::vulkan
