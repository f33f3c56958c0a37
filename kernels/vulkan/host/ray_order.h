// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Records the sort of ray indices on the device (shaders/ray_order.comp), so that neighboring threads visit the same
 * blocks. */

#include "scene.h"

namespace embree::vulkan {

/* Bytes of scratch memory for `count` rays: two arrays of pairs, and the counts of digits. Throws VulkanError if there
 * are too many rays. */
size_t rayOrderBytes(size_t count);

struct RaysToOrder {
  VkDeviceAddress rays;    // each begins with origin, tnear and direction, as RTCRay
  size_t rayBytes, count;  // rayBytes: multiple of 4; count: not 0
  VkDeviceAddress scratch; // of rayOrderBytes(count), aligned to 16
};

/* Records the sort, and a barrier before later compute shaders. The result, sorted pairs (key, index), is at the
 * beginning of scratch. pipelines: from Device::makeOrderPipelines. Records nothing if it throws. */
void recordRayOrder(const Scene& scene, const VkPipeline* pipelines, VkCommandBuffer commands, const RaysToOrder& rays);

} // namespace embree::vulkan
