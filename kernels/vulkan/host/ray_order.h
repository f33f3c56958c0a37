// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Sorts the indices of rays on the device, so that neighbours see the same (shaders/ray_order.comp). */

#include "scene.h"

namespace embree { namespace vulkan {

/* Bytes of scratch that ordering so many rays takes: pairs of key and index twice, and counts. Throws
 * VulkanError for more rays than it can order. */
size_t rayOrderBytes(size_t count);

/* Rays of a buffer; scratch: rayOrderBytes at an address that is a multiple of 16. */
struct RaysToOrder
{
  VkDeviceAddress rays;
  size_t rayBytes, count;
  VkDeviceAddress scratch;
};

/* Records the sort. pipelines: of Device::makeOrderPipelines. The order is then at the begin of scratch, a barrier behind its
 * last write included. Throws VulkanError, before anything is recorded, for more rays than the device orders at once. */
void recordRayOrder(const Scene& scene, const VkPipeline* pipelines, VkCommandBuffer commands, const RaysToOrder& rays);

}} // namespace embree::vulkan
