// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "trace.h"
#include "ray_order.h"

#include <cstdint>
#include <cstring>

namespace embree::vulkan {
namespace {

constexpr uint32_t numStamps = 5; // timestamps: at the start, and after upload, sort, trace and download

void barrier(const DeviceFunctions& vk, VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags written,
             VkPipelineStageFlags to, VkAccessFlags read) {
  VkMemoryBarrier info = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  info.srcAccessMask = written;
  info.dstAccessMask = read;
  vk.CmdPipelineBarrier(commands, from, to, 0, 1, &info, 0, nullptr, 0, nullptr);
}

size_t bytesOfRays(Query query, size_t count) {
  const size_t perRay = query == CLOSEST_HIT ? sizeof(RTCRayHit) : sizeof(RTCRay);
  if (count > SIZE_MAX / perRay)
    throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, "invalid count " + std::to_string(count) + ": expected at most " +
                                                      std::to_string(SIZE_MAX / perRay));
  return count * perRay;
}

} // namespace

Trace::Trace(Scene& scene, Query query, const void* rays, size_t count)
  : device(scene.device),
    held(scene),
    scene(scene),
    query(query),
    count(count),
    bytes(bytesOfRays(query, count)) {
  onDevice.reset(new Buffer(device, bytes, Buffer::OnDevice, "rays"));
  if (!onDevice->mapped && bytes) staging.reset(new Buffer(device, bytes, Buffer::Staging, "rays"));
  if (scene.sortsRays && count > 1)
    order.reset(new Buffer(device, rayOrderBytes(count), Buffer::OnDevice, "keys and indices of rays"));
  if (bytes) std::memcpy(staging ? staging->mapped : onDevice->mapped, rays, bytes);
  try {
    if (device.capabilities.timestampBits) {
      VkQueryPoolCreateInfo info = {VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
      info.queryType = VK_QUERY_TYPE_TIMESTAMP;
      info.queryCount = numStamps;
      check(device.vk.CreateQueryPool(device.handles.device, &info, nullptr, &queryPool), "creating a query pool");
    }
    /* before submit, which records under the mutex that these calls lock */
    const VkPipeline pipeline = device.pipeline(query, scene.usesRayQuery, scene.kinds, scene.statistics.stackSize);
    const VkPipeline* orderPipelines = order ? device.makeOrderPipelines() : nullptr;
    submission = device.submit([&](VkCommandBuffer commands) { record(commands, pipeline, orderPipelines); });
  } catch (...) {
    if (queryPool) device.vk.DestroyQueryPool(device.handles.device, queryPool, nullptr);
    throw;
  }
}

void Trace::record(VkCommandBuffer commands, VkPipeline pipeline, const VkPipeline* orderPipelines) {
  const DeviceFunctions& vk = device.vk;
  auto stamp = [&](uint32_t i, VkPipelineStageFlagBits stage) {
    if (queryPool) vk.CmdWriteTimestamp(commands, stage, queryPool, i);
  };
  if (queryPool) vk.CmdResetQueryPool(commands, queryPool, 0, numStamps);
  stamp(0, VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT);
  const VkBufferCopy all = {0, 0, bytes};
  if (staging) {
    vk.CmdCopyBuffer(commands, staging->handle, onDevice->handle, 1, &all);
    barrier(vk, commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT,
            VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT);
  }
  stamp(1, staging ? VK_PIPELINE_STAGE_TRANSFER_BIT : VK_PIPELINE_STAGE_TOP_OF_PIPE_BIT);
  if (order) recordRayOrder(scene, orderPipelines, commands, {onDevice->address, bytes / count, count, order->address});
  stamp(2, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT);
  scene.record(query, pipeline, commands, onDevice->address, count, order ? order->address : 0);
  stamp(3, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT);
  if (staging) {
    barrier(vk, commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
            VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
    vk.CmdCopyBuffer(commands, onDevice->handle, staging->handle, 1, &all);
  }
  stamp(4, staging ? VK_PIPELINE_STAGE_TRANSFER_BIT : VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT);
  barrier(vk, commands, staging ? VK_PIPELINE_STAGE_TRANSFER_BIT : VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT,
          staging ? VK_ACCESS_TRANSFER_WRITE_BIT : VK_ACCESS_SHADER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
          VK_ACCESS_HOST_READ_BIT);
}

RTCVulkanTraceTimes Trace::readTimes() const {
  RTCVulkanTraceTimes times = RTCVulkanTraceTimes();
  uint64_t stamps[numStamps];
  if (!queryPool || device.vk.GetQueryPoolResults(device.handles.device, queryPool, 0, numStamps, sizeof(stamps),
                                                  stamps, sizeof(uint64_t), VK_QUERY_RESULT_64_BIT) != VK_SUCCESS)
    return times;
  const uint32_t bits = device.capabilities.timestampBits;
  const uint64_t mask = bits >= 64 ? ~uint64_t(0) : (uint64_t(1) << bits) - 1;
  const double tick = 1e-9 * double(device.capabilities.properties.limits.timestampPeriod);
  auto seconds = [&](int from, int to) { return tick * double((stamps[to] - stamps[from]) & mask); };
  times.traceSeconds = seconds(2, 3);
  times.sortSeconds = seconds(1, 2);
  times.copySeconds = seconds(0, 1) + seconds(3, 4);
  return times;
}

void Trace::finish(void* rays, RTCVulkanTraceTimes* times) {
  device.wait(submission);
  if (rays && bytes) std::memcpy(rays, staging ? staging->mapped : onDevice->mapped, bytes);
  if (times) *times = readTimes();
}

Trace::~Trace() {
  device.waitAndFree(submission);
  if (queryPool) device.vk.DestroyQueryPool(device.handles.device, queryPool, nullptr);
}

} // namespace embree::vulkan
