// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "device.h"
#include "../ray_order.h"
#include "kernels/cvert/file/unfinished_file.h"

#include <chrono>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <fstream>
#include <iterator>
#include <thread>
#include <unistd.h>
#include <sys/stat.h>

namespace embree::vulkan {
namespace {

/* SPIR-V of glslc. The Float32 variants are for devices without shaderFloat64. */
const uint32_t closestHit[] =
#include "trace_closest.inc"
    ;
const uint32_t anyHit[] =
#include "trace_any.inc"
    ;
const uint32_t closestHitFloat32[] =
#include "trace_closest_float32.inc"
    ;
const uint32_t anyHitFloat32[] =
#include "trace_any_float32.inc"
    ;
const uint32_t closestHitByQuery[] =
#include "trace_closest_query.inc"
    ;
const uint32_t anyHitByQuery[] =
#include "trace_any_query.inc"
    ;
const uint32_t closestHitByQueryFloat32[] =
#include "trace_closest_query_float32.inc"
    ;
const uint32_t anyHitByQueryFloat32[] =
#include "trace_any_query_float32.inc"
    ;

const uint32_t orderKeys[] =
#include "ray_order_0.inc"
    ;
const uint32_t orderCounts[] =
#include "ray_order_1.inc"
    ;
const uint32_t orderSums[] =
#include "ray_order_2.inc"
    ;
const uint32_t orderScatter[] =
#include "ray_order_3.inc"
    ;

struct Code {
  const uint32_t* words;
  size_t bytes;
};

Code codeOf(Query query, bool usesRayQuery, bool hasFloat64) {
  if (usesRayQuery && hasFloat64)
    return query == CLOSEST_HIT ? Code{closestHitByQuery, sizeof(closestHitByQuery)}
                                : Code{anyHitByQuery, sizeof(anyHitByQuery)};
  if (usesRayQuery)
    return query == CLOSEST_HIT ? Code{closestHitByQueryFloat32, sizeof(closestHitByQueryFloat32)}
                                : Code{anyHitByQueryFloat32, sizeof(anyHitByQueryFloat32)};
  if (hasFloat64) return query == CLOSEST_HIT ? Code{closestHit, sizeof(closestHit)} : Code{anyHit, sizeof(anyHit)};
  return query == CLOSEST_HIT ? Code{closestHitFloat32, sizeof(closestHitFloat32)}
                              : Code{anyHitFloat32, sizeof(anyHitFloat32)};
}

} // namespace

Device::Device(RTCDevice embree, const char* selector) : embree(embree), handles(), vulkanInstance(new VulkanInstance) {
  handles.getInstanceProcAddr = vulkanInstance->getInstanceProcAddr;
  handles.instance = vulkanInstance->instance;
  handles.physicalDevice = chooseDevice(*vulkanInstance, selector ? selector : "");
  instanceFunctions = vulkanInstance->vk;
  capabilities = capabilitiesOf(instanceFunctions, handles.physicalDevice);
  handles.device = createDevice(instanceFunctions, handles.physicalDevice, capabilities);
  handles.queueFamily = capabilities.computeFamily;
  handles.hasFloat64 = capabilities.info.hasFloat64;
  handles.hasHostImport = capabilities.hasHostImport;
  handles.hasRayQuery = capabilities.info.hasRayQuery;
  try {
    vk = DeviceFunctions(instanceFunctions.GetDeviceProcAddr, handles.device, handles.hasHostImport,
                         handles.hasRayQuery);
    vk.GetDeviceQueue(handles.device, handles.queueFamily, 0, &handles.queue);
    open();
  } catch (...) {
    destroy();
    throw;
  }
}

Device::Device(RTCDevice embree, const RTCVulkanDeviceHandles& applicationHandles)
  : embree(embree),
    handles(applicationHandles) {
  instanceFunctions = InstanceFunctions(handles.getInstanceProcAddr, handles.instance);
  capabilities = capabilitiesOf(instanceFunctions, handles.physicalDevice);
  if (capabilities.info.unsupportedReason[0])
    throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, std::string("the Vulkan device ") + capabilities.info.name +
                                                      " cannot be used: " + capabilities.info.unsupportedReason);
  auto checkEnabled = [&](bool isEnabled, bool isPresent, const char* name, const char* member) {
    if (isEnabled && !isPresent)
      throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, std::string("invalid ") + member + ": the Vulkan device " +
                                                        capabilities.info.name + " has no " + name);
  };
  checkEnabled(handles.hasFloat64, capabilities.info.hasFloat64, "shaderFloat64", "hasFloat64");
  checkEnabled(handles.hasHostImport, capabilities.hasHostImport, VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME,
               "hasHostImport");
  checkEnabled(handles.hasRayQuery, capabilities.info.hasRayQuery, VK_KHR_RAY_QUERY_EXTENSION_NAME, "hasRayQuery");
  uint32_t count = 0;
  instanceFunctions.GetPhysicalDeviceQueueFamilyProperties(handles.physicalDevice, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  instanceFunctions.GetPhysicalDeviceQueueFamilyProperties(handles.physicalDevice, &count, families.data());
  if (handles.queueFamily >= count || !(families[handles.queueFamily].queueFlags & VK_QUEUE_COMPUTE_BIT))
    throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, "invalid queueFamily " + std::to_string(handles.queueFamily) +
                                                      ": expected a family with VK_QUEUE_COMPUTE_BIT, below " +
                                                      std::to_string(count));
  capabilities.timestampBits = families[handles.queueFamily].timestampValidBits;
  vk = DeviceFunctions(instanceFunctions.GetDeviceProcAddr, handles.device, handles.hasHostImport, handles.hasRayQuery);
  try {
    open();
  } catch (...) {
    destroy();
    throw;
  }
}

void Device::open() {
  VkCommandPoolCreateInfo poolInfo = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  poolInfo.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  poolInfo.queueFamilyIndex = handles.queueFamily;
  check(vk.CreateCommandPool(handles.device, &poolInfo, nullptr, &pool), "creating a command pool");
  VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0,
                               uint32_t(std::max(sizeof(TraceArguments), sizeof(OrderArguments)))};
  VkPipelineLayoutCreateInfo layoutInfo = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
  layoutInfo.pushConstantRangeCount = 1;
  layoutInfo.pPushConstantRanges = &range;
  check(vk.CreatePipelineLayout(handles.device, &layoutInfo, nullptr, &layout), "creating a pipeline layout");
  readCache();
  if (embree) rtcRetainDevice(embree);
}

Device::~Device() {
  try {
    writeCache();
  } catch (const std::exception&) {} // out of memory: the cache is optional
  destroy();
  if (embree) rtcReleaseDevice(embree);
}

void Device::destroy() {
  if (vk.DestroyDevice) {
    for (VkPipeline pipeline : orderPipelines)
      if (pipeline) vk.DestroyPipeline(handles.device, pipeline, nullptr);
    for (const auto& entry : pipelines)
      if (entry.second) vk.DestroyPipeline(handles.device, entry.second, nullptr);
    if (cache) vk.DestroyPipelineCache(handles.device, cache, nullptr);
    if (layout) vk.DestroyPipelineLayout(handles.device, layout, nullptr);
    if (pool) vk.DestroyCommandPool(handles.device, pool, nullptr);
  }
  if (vulkanInstance && handles.device) {
    const auto destroyDevice =
        PFN_vkDestroyDevice(instanceFunctions.GetDeviceProcAddr(handles.device, "vkDestroyDevice"));
    if (destroyDevice) destroyDevice(handles.device, nullptr);
  }
}

/* --- commands --------------------------------------------------------------------------- */

Device::Submission Device::submit(const std::function<void(VkCommandBuffer)>& record) {
  std::lock_guard<std::mutex> lock(mutex);
  Submission out;
  VkCommandBufferAllocateInfo allocate = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
  allocate.commandPool = pool;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  check(vk.AllocateCommandBuffers(handles.device, &allocate, &out.commands), "allocating a command buffer");
  try {
    VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vk.BeginCommandBuffer(out.commands, &begin), "recording commands");
    record(out.commands);
    check(vk.EndCommandBuffer(out.commands), "recording commands");
    VkFenceCreateInfo fence = {VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    check(vk.CreateFence(handles.device, &fence, nullptr, &out.fence), "creating a fence");
    VkSubmitInfo info = {VK_STRUCTURE_TYPE_SUBMIT_INFO};
    info.commandBufferCount = 1;
    info.pCommandBuffers = &out.commands;
    check(vk.QueueSubmit(handles.queue, 1, &info, out.fence), "submitting commands");
  } catch (...) {
    if (out.fence) vk.DestroyFence(handles.device, out.fence, nullptr);
    vk.FreeCommandBuffers(handles.device, pool, 1, &out.commands);
    throw;
  }
  return out;
}

void Device::wait(const Submission& submission) const {
  check(vk.WaitForFences(handles.device, 1, &submission.fence, VK_TRUE, UINT64_MAX), "waiting for the device");
}

bool Device::isDone(const Submission& submission) const {
  return vk.GetFenceStatus(handles.device, submission.fence) != VK_NOT_READY;
}

/* Retries until the device is done or lost: if waiting fails because the host is out of memory, the device still uses
 * the fence, the commands and the caller's buffers. */
void Device::waitAndFree(const Submission& submission) {
  auto hasEnded = [](VkResult result) { return result == VK_SUCCESS || result == VK_ERROR_DEVICE_LOST; };
  while (!hasEnded(vk.GetFenceStatus(handles.device, submission.fence)))
    if (!hasEnded(vk.WaitForFences(handles.device, 1, &submission.fence, VK_TRUE, UINT64_MAX)))
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::lock_guard<std::mutex> lock(mutex);
  vk.DestroyFence(handles.device, submission.fence, nullptr);
  vk.FreeCommandBuffers(handles.device, pool, 1, &submission.commands);
}

void Device::run(const std::function<void(VkCommandBuffer)>& record) {
  const Submission submission = submit(record);
  try {
    wait(submission);
  } catch (...) {
    waitAndFree(submission);
    throw;
  }
  waitAndFree(submission);
}

/* --- pipelines -------------------------------------------------------------------------- */

VkPipeline Device::pipeline(Query query, bool usesRayQuery, uint32_t kinds, uint32_t stackSize) {
  std::lock_guard<std::mutex> lock(mutex);
  VkPipeline& found = pipelines[std::make_tuple(query, usesRayQuery, kinds, stackSize)];
  if (found) return found;

  const Code code = codeOf(query, usesRayQuery, handles.hasFloat64);
  const uint32_t constants[2] = {kinds, stackSize};
  const VkSpecializationMapEntry entries[2] = {{0, 0, sizeof(uint32_t)}, {1, sizeof(uint32_t), sizeof(uint32_t)}};
  const VkSpecializationInfo specialization = {2, entries, sizeof(constants), constants};
  found = compile(code.words, code.bytes, &specialization);
  return found;
}

const VkPipeline* Device::makeOrderPipelines() {
  const VkPhysicalDeviceLimits& limits = capabilities.properties.limits; // Vulkan guarantees 128
  const uint32_t threads = std::min(limits.maxComputeWorkGroupInvocations, limits.maxComputeWorkGroupSize[0]);
  if (threads < cbvh::orderThreads)
    throw VulkanError(RTC_ERROR_INVALID_OPERATION, std::string("the Vulkan device ") + capabilities.info.name +
                                                       " cannot sort rays: its workgroups have at most " +
                                                       std::to_string(threads) + " threads, " +
                                                       std::to_string(cbvh::orderThreads) + " are needed");
  std::lock_guard<std::mutex> lock(mutex);
  const Code codes[4] = {{orderKeys, sizeof(orderKeys)},
                         {orderCounts, sizeof(orderCounts)},
                         {orderSums, sizeof(orderSums)},
                         {orderScatter, sizeof(orderScatter)}};
  for (int stage = 0; stage < 4; stage++)
    if (!orderPipelines[stage]) orderPipelines[stage] = compile(codes[stage].words, codes[stage].bytes, nullptr);
  return orderPipelines;
}

VkPipeline Device::compile(const uint32_t* words, size_t bytes, const VkSpecializationInfo* specialization) {
  VkShaderModuleCreateInfo moduleInfo = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
  moduleInfo.codeSize = bytes;
  moduleInfo.pCode = words;
  VkShaderModule module;
  check(vk.CreateShaderModule(handles.device, &moduleInfo, nullptr, &module), "creating a shader");
  VkComputePipelineCreateInfo info = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
  info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
  info.stage.module = module;
  info.stage.pName = "main";
  info.stage.pSpecializationInfo = specialization;
  info.layout = layout;
  VkPipeline pipeline = VK_NULL_HANDLE;
  const VkResult result = vk.CreateComputePipelines(handles.device, cache, 1, &info, nullptr, &pipeline);
  vk.DestroyShaderModule(handles.device, module, nullptr);
  check(result, "compiling a shader");
  return pipeline;
}

/* File that keeps compiled pipelines between runs of programs, or "" if neither XDG_CACHE_HOME nor HOME is set. */
std::string Device::cachePath() const {
  const char* folder = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  if ((!folder || !*folder) && (!home || !*home)) return "";
  std::string path = folder && *folder ? std::string(folder) : std::string(home) + "/.cache";
  path += "/embree-cbvh";
  char id[2 * VK_UUID_SIZE + 1] = "";
  for (size_t i = 0; i < VK_UUID_SIZE; i++) std::snprintf(id + 2 * i, 3, "%02x", capabilities.cacheID[i]);
  return path + "/vulkan-" + id;
}

/* FNV-1a hash, to detect damaged cache files, on which drivers may crash. */
uint64_t Device::checksum(const std::vector<char>& data) {
  uint64_t sum = 0xcbf29ce484222325;
  for (char c : data) sum = (sum ^ (unsigned char)c) * 0x100000001b3;
  return sum;
}

void Device::readCache() {
  std::vector<char> data;
  const std::string path = cachePath();
  struct stat status;
  if (!path.empty() && stat(path.c_str(), &status) == 0 && S_ISREG(status.st_mode)) { // opening a pipe would block
    std::ifstream file(path, std::ios::binary);
    uint64_t sum = 0;
    if (file.read(reinterpret_cast<char*>(&sum), sizeof(sum)))
      data.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    if (checksum(data) != sum) data.clear();
  }
  VkPipelineCacheCreateInfo info = {VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO};
  info.initialDataSize = data.size();
  info.pInitialData = data.data();
  check(vk.CreatePipelineCache(handles.device, &info, nullptr, &cache), "creating a pipeline cache");
  cacheBytes = data.size();
}

void Device::writeCache() const {
  const std::string path = cachePath();
  size_t bytes = 0;
  if (path.empty() || vk.GetPipelineCacheData(handles.device, cache, &bytes, nullptr) != VK_SUCCESS ||
      bytes <= cacheBytes)
    return;
  std::vector<char> data(bytes);
  if (vk.GetPipelineCacheData(handles.device, cache, &bytes, data.data()) != VK_SUCCESS) return;
  data.resize(bytes);
  const std::string folder = path.substr(0, path.rfind('/'));
  mkdir(folder.substr(0, folder.rfind('/')).c_str(), 0755);
  mkdir(folder.c_str(), 0755);
  const uint64_t sum = checksum(data);
  try {
    cvert::UnfinishedFile file{cvert::OutputPath(path)};
    const int error = cvert::writeAll(file.descriptor(), &sum, sizeof(sum));
    if (!error && cvert::writeAll(file.descriptor(), data.data(), bytes) == 0) file.commit();
  } catch (const std::exception&) {} // not an error: the next run compiles again
}

} // namespace embree::vulkan
