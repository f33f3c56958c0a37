// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "ray_order.h"
#include "../ray_order.h"

namespace embree::vulkan {

using namespace cbvh;

namespace {

/* Largest power of two for which shaders can index all words of RTCRayHits, 20 per ray, with 32 bits.
 * recordRayOrder() checks longer strides. */
constexpr size_t maxRays = size_t(1) << 27;

size_t tilesOf(size_t count) { return (count + orderTileSize - 1) / orderTileSize; }
size_t pairBytes(size_t count) { return (8 * count + 15) & ~size_t(15); }

} // namespace

size_t rayOrderBytes(size_t count) {
  if (count > maxRays)
    throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, "invalid count " + std::to_string(count) + ": at most " +
                                                      std::to_string(maxRays) + " rays are ordered at once");
  return 2 * pairBytes(count) + ((4 * orderRadix * tilesOf(count) + 15) & ~size_t(15));
}

void recordRayOrder(const Scene& scene, const VkPipeline* pipelines, VkCommandBuffer commands,
                    const RaysToOrder& rays) {
  const Device& device = scene.device;
  const DeviceFunctions& vk = device.vk;
  const size_t groups = (rays.count + orderThreads - 1) / orderThreads,
               maxGroups = device.capabilities.properties.limits.maxComputeWorkGroupCount[0];
  if (groups > maxGroups)
    throw VulkanError(
        RTC_ERROR_INVALID_ARGUMENT,
        "invalid count " + std::to_string(rays.count) + ": at most " + std::to_string(maxGroups * orderThreads) +
            " rays are ordered at once, the device's maxComputeWorkGroupCount is " + std::to_string(maxGroups));
  const size_t words = rays.rayBytes / 4;
  if (words > (size_t(1) << 32) / rays.count)
    throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, "invalid stride " + std::to_string(rays.rayBytes) + " of " +
                                                      std::to_string(rays.count) + " rays: expected at most " +
                                                      std::to_string(4 * ((size_t(1) << 32) / rays.count)) + " bytes");
  const uint32_t tiles = uint32_t(tilesOf(rays.count));
  const VkDeviceAddress pairs[2] = {rays.scratch, rays.scratch + pairBytes(rays.count)},
                        counts = rays.scratch + 2 * pairBytes(rays.count);
  auto stage = [&](int which, const OrderArguments& arguments, uint32_t groups) {
    vk.CmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines[which]);
    vk.CmdPushConstants(commands, device.pipelineLayout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(arguments),
                        &arguments);
    vk.CmdDispatch(commands, groups, 1, 1);
    VkMemoryBarrier barrier = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
    vk.CmdPipelineBarrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, 0, 1,
                          &barrier, 0, nullptr, 0, nullptr);
  };
  const uint32_t count = uint32_t(rays.count);
  stage(0, {rays.rays, 0, pairs[0], counts, scene.address, count, uint32_t(words), 0}, uint32_t(groups));
  for (uint32_t pass = 0; pass < orderPasses; pass++) {
    const VkDeviceAddress from = pairs[pass % 2], to = pairs[1 - pass % 2];
    const uint32_t shift = orderDigitBits * pass;
    stage(1, {0, from, to, counts, 0, count, 0, shift}, tiles);
    stage(2, {0, from, to, counts, 0, tiles, 0, shift}, 1);
    stage(3, {0, from, to, counts, 0, count, 0, shift}, tiles);
  }
  static_assert(orderPasses % 2 == 0, "the last pass must write to the beginning of scratch");
}

} // namespace embree::vulkan
