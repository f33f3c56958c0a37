// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* What a driver makes of the shader that finds closest hits, per kind of leaf: registers, spilled registers, bytes of
 * code and estimated latency. Prints a table, and fails if a kind exceeds its limit. Mesa's RADV compiles for a GPU
 * that the machine does not have, named by RADV_FORCE_FAMILY; limits are for navi31 and Mesa 25.0. Exits with 77 if the
 * driver has no statistics or another version. */

#include "kernels/cbvh/base/reference.h"

#include <vulkan/vulkan.h>

#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using namespace embree::cbvh;

const uint32_t code[] =
#include "trace_closest.inc"
    ;

struct Kernel {
  const char* name;
  uint32_t kinds; // as rtcGetVulkanSceneLeafKinds
  uint64_t maxRegisters, maxCodeBytes;
};

const Kernel kernels[] = {
    {"GRID", 1u << gridLeafReferenceType, 72, 5000},
    {"triangles", 1u << firstRunReferenceType, 72, 5500},
    {"tiles", 1u << blockReferenceType(kindTile), 192, 24 * 1024},
    {"cVERT", 1u << blockReferenceType(kindVert), 256, 90 * 1024},
    {"cVERT, mesh blocks", 1u << meshBlockReferenceType, 256, 64 * 1024},
};

void require(VkResult result, const char* what) {
  if (result != VK_SUCCESS) throw std::runtime_error(std::string(what) + " failed: " + std::to_string(result));
}

class NullDevice {
public:
  NullDevice() {
    VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.apiVersion = VK_API_VERSION_1_2;
    VkInstanceCreateInfo instanceInfo = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    instanceInfo.pApplicationInfo = &application;
    require(vkCreateInstance(&instanceInfo, nullptr, &instance), "vkCreateInstance");
    uint32_t count = 1;
    vkEnumeratePhysicalDevices(instance, &count, &physical);
    if (count == 0) return;
    VkPhysicalDeviceDriverProperties driver = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
    properties.pNext = &driver;
    vkGetPhysicalDeviceProperties2(physical, &properties);
    name = properties.properties.deviceName;
    version = driver.driverInfo;

    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR statistics = {
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR};
    statistics.pipelineExecutableInfo = VK_TRUE;
    VkPhysicalDeviceVulkan12Features vulkan12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    vulkan12.pNext = &statistics;
    vulkan12.bufferDeviceAddress = vulkan12.scalarBlockLayout = VK_TRUE;
    VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    features.pNext = &vulkan12;
    features.features.shaderFloat64 = VK_TRUE;
    const float priority = 1;
    VkDeviceQueueCreateInfo queue = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    const char* const extension = VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;
    VkDeviceCreateInfo info = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    info.pNext = &features;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
    if (vkCreateDevice(physical, &info, nullptr, &device) != VK_SUCCESS) device = VK_NULL_HANDLE;
  }

  ~NullDevice() {
    if (device) vkDestroyDevice(device, nullptr);
    vkDestroyInstance(instance, nullptr);
  }

  bool hasStatistics() const { return device != VK_NULL_HANDLE; }

  // stackSize: see CBVH_STACK_SIZE.
  VkPipeline compile(uint32_t kinds, uint32_t stackSize) {
    VkShaderModuleCreateInfo moduleInfo = {VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    moduleInfo.codeSize = sizeof(code);
    moduleInfo.pCode = code;
    VkShaderModule module;
    require(vkCreateShaderModule(device, &moduleInfo, nullptr, &module), "vkCreateShaderModule");
    const VkPushConstantRange range = {VK_SHADER_STAGE_COMPUTE_BIT, 0, 64};
    VkPipelineLayoutCreateInfo layoutInfo = {VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layoutInfo.pushConstantRangeCount = 1;
    layoutInfo.pPushConstantRanges = &range;
    VkPipelineLayout layout;
    require(vkCreatePipelineLayout(device, &layoutInfo, nullptr, &layout), "vkCreatePipelineLayout");
    const uint32_t constants[2] = {kinds, stackSize};
    const VkSpecializationMapEntry entries[2] = {{0, 0, 4}, {1, 4, 4}};
    const VkSpecializationInfo specialization = {2, entries, sizeof(constants), constants};
    VkComputePipelineCreateInfo info = {VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
    info.stage = {VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO};
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module;
    info.stage.pName = "main";
    info.stage.pSpecializationInfo = &specialization;
    info.layout = layout;
    VkPipeline pipeline;
    require(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline), "vkCreateComputePipelines");
    vkDestroyPipelineLayout(device, layout, nullptr);
    vkDestroyShaderModule(device, module, nullptr);
    return pipeline;
  }

  // Of the pipeline's only executable.
  uint64_t statistic(VkPipeline pipeline, const char* name) const {
    const auto get =
        (PFN_vkGetPipelineExecutableStatisticsKHR)vkGetDeviceProcAddr(device, "vkGetPipelineExecutableStatisticsKHR");
    VkPipelineExecutableInfoKHR info = {VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR};
    info.pipeline = pipeline;
    uint32_t count = 0;
    require(get(device, &info, &count, nullptr), "vkGetPipelineExecutableStatisticsKHR");
    std::vector<VkPipelineExecutableStatisticKHR> all(count, {VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR});
    require(get(device, &info, &count, all.data()), "vkGetPipelineExecutableStatisticsKHR");
    for (const VkPipelineExecutableStatisticKHR& s : all)
      if (std::strcmp(s.name, name) == 0) return s.value.u64;
    throw std::runtime_error(std::string("the driver has no statistic ") + name);
  }

  void destroy(VkPipeline pipeline) { vkDestroyPipeline(device, pipeline, nullptr); }

  std::string name, version;

private:
  VkInstance instance = VK_NULL_HANDLE;
  VkPhysicalDevice physical = VK_NULL_HANDLE;
  VkDevice device = VK_NULL_HANDLE;
};

} // namespace

int main() {
  NullDevice device;
  if (!device.hasStatistics()) {
    std::printf("skipped: no Vulkan driver with statistics of pipelines\n");
    return 77;
  }
  std::printf("%s, %s\n%-20s %9s %8s %6s %9s\n", device.name.c_str(), device.version.c_str(), "leaves", "registers",
              "spilled", "bytes", "latency");
  bool isWithin = true;
  for (const Kernel& kernel : kernels) {
    const VkPipeline pipeline = device.compile(kernel.kinds, 64);
    const uint64_t registers = device.statistic(pipeline, "VGPRs"),
                   spilled = device.statistic(pipeline, "Spilled VGPRs"),
                   bytes = device.statistic(pipeline, "Code size"), latency = device.statistic(pipeline, "Latency");
    device.destroy(pipeline);
    const bool fits = registers <= kernel.maxRegisters && bytes <= kernel.maxCodeBytes && spilled == 0;
    std::printf("%-20s %9llu %8llu %6llu %9llu%s\n", kernel.name, (unsigned long long)registers,
                (unsigned long long)spilled, (unsigned long long)bytes, (unsigned long long)latency,
                fits ? "" : "   exceeds its limit");
    isWithin &= fits;
  }
  if (device.version.rfind("Mesa 25.0.", 0) != 0) {
    std::printf("skipped: the limits are for Mesa 25.0\n");
    return 77;
  }
  return isWithin ? 0 : 1;
}
