// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Traces the paths of path.h in a compute shader, path.comp, which includes the library's cbvh.glsl and receives the
 * scene as an address. */

#include "vulkan_device.h"
#include "path_tracer.h"
#include "basics/progress.h"

#include <algorithm>
#include <cstring>

namespace programs {
namespace {

using path::PathArguments;

/* SPIR-V of path.comp. Variants without 64-bit floats cannot trace cVERT. */
const uint32_t code[] =
#include "path.inc"
    ;
const uint32_t codeFloat32[] =
#include "path_float32.inc"
    ;
const uint32_t codeByQuery[] =
#include "path_query.inc"
    ;
const uint32_t codeByQueryFloat32[] =
#include "path_query_float32.inc"
    ;

struct Code {
  const uint32_t* words;
  size_t bytes;
};

Code codeFor(bool byRayQuery, bool hasFloat64) {
  if (byRayQuery)
    return hasFloat64 ? Code{codeByQuery, sizeof(codeByQuery)} : Code{codeByQueryFloat32, sizeof(codeByQueryFloat32)};
  return hasFloat64 ? Code{code, sizeof(code)} : Code{codeFloat32, sizeof(codeFloat32)};
}

constexpr uint32_t groupSize = 8; // as in path.comp

/* Paths per submission, approximately: drivers may abort work that takes seconds, and Ctrl-C waits for it. */
constexpr uint32_t pathsPerSubmission = 1u << 18;

class UploadedScene {
public:
  UploadedScene(VulkanDevice& device, RTCScene scene, bool byRayQuery) : handle(create(device, scene, byRayQuery)) {
    device.check("uploading the scene to the Vulkan device");
  }
  ~UploadedScene() { rtcReleaseVulkanScene(handle); }
  UploadedScene(const UploadedScene&) = delete;
  UploadedScene& operator=(const UploadedScene&) = delete;

  const RTCVulkanScene handle;

private:
  static RTCVulkanScene create(VulkanDevice& device, RTCScene scene, bool byRayQuery) {
    RTCVulkanSceneArguments args = {};
    args.traversal = byRayQuery ? RTC_VULKAN_TRAVERSAL_RAY_QUERY : RTC_VULKAN_TRAVERSAL_COMPUTE;
    return rtcNewVulkanScene(device.handle(), scene, &args);
  }
};

class PathPipeline {
public:
  PathPipeline(const VulkanDevice& device, RTCVulkanScene scene, bool byRayQuery) : device(device.vk.device) {
    try {
      create(codeFor(byRayQuery, device.vk.hasFloat64), scene);
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~PathPipeline() { destroy(); }
  PathPipeline(const PathPipeline&) = delete;
  PathPipeline& operator=(const PathPipeline&) = delete;

  /* Starts at the first row of the arguments. */
  void record(VkCommandBuffer commands, const PathArguments& arguments, uint32_t rows) const {
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline);
    vkCmdPushConstants(commands, layout, VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(arguments), &arguments);
    vkCmdDispatch(commands, (arguments.view.width + groupSize - 1) / groupSize, (rows + groupSize - 1) / groupSize, 1);
  }

private:
  void create(const Code& code, RTCVulkanScene scene) {
    const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(PathArguments)};
    VkPipelineLayoutCreateInfo layoutInfo = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layoutInfo.pushConstantRangeCount = 1;
    layoutInfo.pPushConstantRanges = &range;
    checkVulkan(vkCreatePipelineLayout(device, &layoutInfo, nullptr, &layout), "creating a pipeline layout");

    VkShaderModuleCreateInfo moduleInfo = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    moduleInfo.codeSize = code.bytes;
    moduleInfo.pCode = code.words;
    checkVulkan(vkCreateShaderModule(device, &moduleInfo, nullptr, &module), "creating a shader");

    RTCVulkanSceneStatistics statistics;
    rtcGetVulkanSceneStatistics(scene, &statistics);
    const uint32_t constants[2] = {rtcGetVulkanSceneLeafKinds(scene), statistics.stackSize};
    const VkSpecializationMapEntry entries[2] = {{0, 0, sizeof(uint32_t)}, {1, sizeof(uint32_t), sizeof(uint32_t)}};
    const VkSpecializationInfo specialization = {2, entries, sizeof(constants), constants};
    VkComputePipelineCreateInfo info = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module;
    info.stage.pName = "main";
    info.stage.pSpecializationInfo = &specialization;
    info.layout = layout;
    checkVulkan(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline), "compiling the shader");
  }

  void destroy() {
    vkDestroyPipeline(device, pipeline, nullptr);
    vkDestroyShaderModule(device, module, nullptr);
    vkDestroyPipelineLayout(device, layout, nullptr);
  }

  VkDevice device;
  VkPipelineLayout layout = VK_NULL_HANDLE;
  VkShaderModule module = VK_NULL_HANDLE;
  VkPipeline pipeline = VK_NULL_HANDLE;
};

void barrier(VkCommandBuffer commands, VkPipelineStageFlags from, VkAccessFlags written, VkPipelineStageFlags to,
             VkAccessFlags used) {
  VkMemoryBarrier info = {VK_STRUCTURE_TYPE_MEMORY_BARRIER};
  info.srcAccessMask = written;
  info.dstAccessMask = used;
  vkCmdPipelineBarrier(commands, from, to, 0, 1, &info, 0, nullptr, 0, nullptr);
}

class VulkanPathTracer : public PathTracer {
public:
  VulkanPathTracer(RTCScene from, const PathView& view, const std::string& selector, bool byRayQuery)
    : device(selector),
      scene(device, from, byRayQuery),
      pipeline(device, scene.handle, byRayQuery),
      view(view),
      light(device, sizeof(Vec3f) * view.width * view.height, VulkanBuffer::DeviceLocal),
      readable(device, light.bytes, VulkanBuffer::HostReadable) {}

  std::string deviceName() const override { return device.name(); }

private:
  void addSample(uint32_t sampleIndex) override {
    PathArguments arguments;
    arguments.scene = rtcGetVulkanSceneAddress(scene.handle);
    arguments.sums = light.address;
    arguments.view = view;
    arguments.sampleIndex = sampleIndex;
    const uint32_t rows = std::max(pathsPerSubmission / view.width / groupSize, 1u) * groupSize; // whole groups
    for (arguments.firstRow = 0; arguments.firstRow < view.height; arguments.firstRow += rows) {
      throwIfCanceled();
      device.run([&](VkCommandBuffer commands) {
        constexpr VkPipelineStageFlags compute = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT;
        constexpr VkPipelineStageFlags transfer = VK_PIPELINE_STAGE_TRANSFER_BIT;
        constexpr VkAccessFlags readAndWrite = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT;
        barrier(commands, compute | transfer, VK_ACCESS_SHADER_WRITE_BIT, compute, readAndWrite); // previous sample
        pipeline.record(commands, arguments, std::min(rows, view.height - arguments.firstRow));
      });
    }
  }

  std::vector<Vec3f> sums() const override {
    device.run([&](VkCommandBuffer commands) {
      barrier(commands, VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT, VK_ACCESS_SHADER_WRITE_BIT,
              VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_READ_BIT);
      const VkBufferCopy all = {0, 0, light.bytes};
      vkCmdCopyBuffer(commands, light.handle, readable.handle, 1, &all);
      barrier(commands, VK_PIPELINE_STAGE_TRANSFER_BIT, VK_ACCESS_TRANSFER_WRITE_BIT, VK_PIPELINE_STAGE_HOST_BIT,
              VK_ACCESS_HOST_READ_BIT);
    });
    std::vector<Vec3f> out(size_t(view.width) * view.height);
    std::memcpy(out.data(), readable.mapped, light.bytes);
    return out;
  }

  VulkanDevice device; // destroyed last
  const UploadedScene scene;
  const PathPipeline pipeline;
  const PathView view;
  const VulkanBuffer light, readable;
};

} // namespace

std::unique_ptr<PathTracer> makeVulkanPathTracer(RTCScene scene, const PathView& view, const std::string& selector,
                                                 bool byRayQuery) {
  return std::make_unique<VulkanPathTracer>(scene, view, selector, byRayQuery);
}

} // namespace programs
