// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "opening.h"

#include "kernels/cbvh/operations/lower_case.h"

#include <dlfcn.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace embree::vulkan {
namespace {

const char* nameOf(VkResult result) {
  switch (result) {
  case VK_ERROR_OUT_OF_HOST_MEMORY: return "VK_ERROR_OUT_OF_HOST_MEMORY";
  case VK_ERROR_OUT_OF_DEVICE_MEMORY: return "VK_ERROR_OUT_OF_DEVICE_MEMORY";
  case VK_ERROR_INITIALIZATION_FAILED: return "VK_ERROR_INITIALIZATION_FAILED";
  case VK_ERROR_DEVICE_LOST: return "VK_ERROR_DEVICE_LOST";
  case VK_ERROR_MEMORY_MAP_FAILED: return "VK_ERROR_MEMORY_MAP_FAILED";
  case VK_ERROR_LAYER_NOT_PRESENT: return "VK_ERROR_LAYER_NOT_PRESENT";
  case VK_ERROR_EXTENSION_NOT_PRESENT: return "VK_ERROR_EXTENSION_NOT_PRESENT";
  case VK_ERROR_FEATURE_NOT_PRESENT: return "VK_ERROR_FEATURE_NOT_PRESENT";
  case VK_ERROR_INCOMPATIBLE_DRIVER: return "VK_ERROR_INCOMPATIBLE_DRIVER";
  case VK_ERROR_TOO_MANY_OBJECTS: return "VK_ERROR_TOO_MANY_OBJECTS";
  case VK_ERROR_INVALID_EXTERNAL_HANDLE: return "VK_ERROR_INVALID_EXTERNAL_HANDLE";
  case VK_ERROR_OUT_OF_POOL_MEMORY: return "VK_ERROR_OUT_OF_POOL_MEMORY";
  case VK_ERROR_FRAGMENTED_POOL: return "VK_ERROR_FRAGMENTED_POOL";
  case VK_ERROR_FRAGMENTATION: return "VK_ERROR_FRAGMENTATION";
  default: return nullptr;
  }
}

template<size_t N>
void setText(char (&to)[N], const std::string& from) {
  std::snprintf(to, N, "%s", from.c_str());
}

std::string versionText(uint32_t version) {
  return std::to_string(VK_API_VERSION_MAJOR(version)) + "." + std::to_string(VK_API_VERSION_MINOR(version)) + "." +
         std::to_string(VK_API_VERSION_PATCH(version));
}

bool isOutOfMemory(VkResult result) {
  switch (result) {
  case VK_ERROR_OUT_OF_HOST_MEMORY:
  case VK_ERROR_OUT_OF_DEVICE_MEMORY:
  case VK_ERROR_TOO_MANY_OBJECTS:
  case VK_ERROR_MEMORY_MAP_FAILED:
  case VK_ERROR_OUT_OF_POOL_MEMORY:
  case VK_ERROR_FRAGMENTED_POOL:
  case VK_ERROR_FRAGMENTATION: return true;
  default: return false;
  }
}

const char* const rayQueryExtensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME, VK_KHR_RAY_QUERY_EXTENSION_NAME,
                                          VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};

bool hasExtension(const InstanceFunctions& vk, VkPhysicalDevice device, const char* name) {
  uint32_t count = 0;
  check(vk.EnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr), "listing extensions");
  std::vector<VkExtensionProperties> extensions(count);
  check(vk.EnumerateDeviceExtensionProperties(device, nullptr, &count, extensions.data()), "listing extensions");
  return std::any_of(extensions.begin(), extensions.begin() + count,
                     [&](const VkExtensionProperties& e) { return !std::strcmp(e.extensionName, name); });
}

} // namespace

void check(VkResult result, const std::string& doing) {
  if (result >= VK_SUCCESS) return;
  const char* name = nameOf(result);
  throw VulkanError(
      isOutOfMemory(result) ? RTC_ERROR_OUT_OF_MEMORY : RTC_ERROR_UNKNOWN,
      "Vulkan: " + doing + " failed: " + (name ? name : "VkResult " + std::to_string(result)) +
          (result == VK_ERROR_DEVICE_LOST ? "; the device is lost: release it, its scenes and its traces" : ""));
}

/* --- loader and instance ---------------------------------------------------------------- */

VulkanInstance::VulkanInstance() {
  const char* named = secure_getenv("EMBREE_VULKAN_LOADER");
  if (named && !*named) named = nullptr;
  loader = dlopen(named ? named : "libvulkan.so.1", RTLD_NOW | RTLD_LOCAL);
  if (!loader && named) {
    const char* reason = dlerror();
    throw VulkanError(RTC_ERROR_UNSUPPORTED_CPU,
                      std::string("the loader of Vulkan that EMBREE_VULKAN_LOADER names, '") + named +
                          "', cannot be loaded: " + (reason ? reason : "no reason is known"));
  }
  if (!loader)
    throw VulkanError(RTC_ERROR_UNSUPPORTED_CPU,
                      "Vulkan's loader, libvulkan.so.1, cannot be loaded "
                      "(Debian: libvulkan1, and mesa-vulkan-drivers or the vendor's driver)");
  try {
    getInstanceProcAddr = PFN_vkGetInstanceProcAddr(dlsym(loader, "vkGetInstanceProcAddr"));
    InstanceFunctions::check(PFN_vkVoidFunction(getInstanceProcAddr), "vkGetInstanceProcAddr");
    const auto create = PFN_vkCreateInstance(getInstanceProcAddr(nullptr, "vkCreateInstance"));
    InstanceFunctions::check(PFN_vkVoidFunction(create), "vkCreateInstance");
    VkApplicationInfo application = {VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.pApplicationName = "Embree CBVH";
    application.apiVersion = VK_API_VERSION_1_2;
    VkInstanceCreateInfo info = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;
    const VkResult result = create(&info, nullptr, &instance);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
      throw VulkanError(RTC_ERROR_UNSUPPORTED_CPU,
                        "Vulkan's loader found no driver that works: VK_ERROR_INCOMPATIBLE_DRIVER. "
                        "Either none is installed (Debian: mesa-vulkan-drivers, or the vendor's), or it failed: "
                        "with VK_LOADER_DEBUG=error the loader prints why");
    check(result, "creating an instance");
    vk = InstanceFunctions(getInstanceProcAddr, instance);
  } catch (...) {
    if (const auto destroy =
            instance ? PFN_vkDestroyInstance(getInstanceProcAddr(instance, "vkDestroyInstance")) : nullptr)
      destroy(instance, nullptr);
    dlclose(loader);
    throw;
  }
}

VulkanInstance::~VulkanInstance() {
  vk.DestroyInstance(instance, nullptr);
  dlclose(loader);
}

std::vector<VkPhysicalDevice> VulkanInstance::devices() const {
  uint32_t count = 0;
  check(vk.EnumeratePhysicalDevices(instance, &count, nullptr), "listing devices");
  std::vector<VkPhysicalDevice> devices(count);
  check(vk.EnumeratePhysicalDevices(instance, &count, devices.data()), "listing devices");
  devices.resize(count);
  return devices;
}

/* --- devices ---------------------------------------------------------------------------- */

/* Sets the name first, which is then known if a later call fails. */
static void readCapabilities(const InstanceFunctions& vk, VkPhysicalDevice device, Capabilities& out) {
  out.info = RTCVulkanDeviceInfo();
  vk.GetPhysicalDeviceProperties(device, &out.properties);
  vk.GetPhysicalDeviceMemoryProperties(device, &out.memory);
  setText(out.info.name, out.properties.deviceName);
  std::memcpy(out.cacheID, out.properties.pipelineCacheUUID, VK_UUID_SIZE);
  for (uint32_t i = 0; i < out.memory.memoryHeapCount; i++)
    if (out.memory.memoryHeaps[i].flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT)
      out.info.memoryBytes = std::max(out.info.memoryBytes, size_t(out.memory.memoryHeaps[i].size));
  out.info.isDiscrete = out.properties.deviceType == VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  if (out.properties.apiVersion < VK_API_VERSION_1_2) {
    setText(out.info.unsupportedReason,
            "its driver has Vulkan " + versionText(out.properties.apiVersion) + ", 1.2 is needed");
    return;
  }

  out.hasHostImport = hasExtension(vk, device, VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME);
  VkPhysicalDeviceExternalMemoryHostPropertiesEXT host = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_EXTERNAL_MEMORY_HOST_PROPERTIES_EXT};
  VkPhysicalDeviceVulkan12Properties v12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_PROPERTIES};
  VkPhysicalDeviceMaintenance3Properties maintenance = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES};
  VkPhysicalDeviceAccelerationStructurePropertiesKHR structures = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_PROPERTIES_KHR};
  const bool hasRayQuery = std::all_of(std::begin(rayQueryExtensions), std::end(rayQueryExtensions),
                                       [&](const char* name) { return hasExtension(vk, device, name); });
  VkPhysicalDeviceProperties2 properties = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2};
  properties.pNext = &maintenance;
  maintenance.pNext = &v12;
  if (out.hasHostImport) v12.pNext = &host;
  if (hasRayQuery) {
    structures.pNext = properties.pNext;
    properties.pNext = &structures;
  }
  vk.GetPhysicalDeviceProperties2(device, &properties);
  setText(out.info.driver, std::string(v12.driverName) + " " + v12.driverInfo);
  out.maxAllocation = size_t(maintenance.maxMemoryAllocationSize);
  if (out.hasHostImport) out.importAlignment = std::max(size_t(4096), size_t(host.minImportedHostPointerAlignment));

  VkPhysicalDeviceVulkan12Features f12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  VkPhysicalDeviceRayQueryFeaturesKHR query = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};
  VkPhysicalDeviceAccelerationStructureFeaturesKHR structureFeatures = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
  structureFeatures.pNext = &query;
  VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
  features.pNext = &f12;
  if (hasRayQuery) f12.pNext = &structureFeatures;
  vk.GetPhysicalDeviceFeatures2(device, &features);
  out.info.hasRayQuery = hasRayQuery && query.rayQuery && structureFeatures.accelerationStructure;
  out.scratchAlignment =
      std::max(out.scratchAlignment, size_t(structures.minAccelerationStructureScratchOffsetAlignment));
  out.maxBoxes = structures.maxPrimitiveCount;
  out.maxInstances = std::min(uint64_t(structures.maxInstanceCount), uint64_t(1) << 24); // a custom index has 24 bits
  out.info.hasFloat64 = features.features.shaderFloat64;
  std::string missing;
  if (!f12.bufferDeviceAddress) missing = "it has no bufferDeviceAddress";
  if (!f12.scalarBlockLayout)
    missing += (missing.empty() ? "it has no " : " and no ") + std::string("scalarBlockLayout");

  uint32_t count = 0;
  vk.GetPhysicalDeviceQueueFamilyProperties(device, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vk.GetPhysicalDeviceQueueFamilyProperties(device, &count, families.data());
  for (uint32_t i = 0; i < count && out.computeFamily == ~0u; i++)
    if (families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) {
      out.computeFamily = i;
      out.timestampBits = families[i].timestampValidBits;
    }
  if (out.computeFamily == ~0u)
    missing += std::string(missing.empty() ? "" : ", and ") + "it has no queue that computes";
  setText(out.info.unsupportedReason, missing);
}

Capabilities capabilitiesOf(const InstanceFunctions& vk, VkPhysicalDevice device) {
  Capabilities out;
  readCapabilities(vk, device, out);
  return out;
}

Capabilities examineDevice(const InstanceFunctions& vk, VkPhysicalDevice device) {
  Capabilities out;
  try {
    readCapabilities(vk, device, out);
  } catch (const VulkanError& error) {
    out.driverError = error.code;
    setText(out.info.unsupportedReason, std::string("its driver failed: ") + error.what());
  }
  return out;
}

VkPhysicalDevice chooseDevice(const VulkanInstance& vulkan, const std::string& selector) {
  const std::vector<VkPhysicalDevice> devices = vulkan.devices();
  if (devices.empty())
    throw VulkanError(RTC_ERROR_UNSUPPORTED_CPU, "Vulkan finds no device on this machine "
                                                 "(Debian: mesa-vulkan-drivers, or the vendor's driver)");
  const bool isIndex = !selector.empty() && selector.find_first_not_of("0123456789") == std::string::npos;
  std::string known, unsupported;
  VkPhysicalDevice best = VK_NULL_HANDLE;
  bool isBestDiscrete = false;
  RTCError unsupportedError = RTC_ERROR_UNSUPPORTED_CPU;
  for (size_t i = 0; i < devices.size(); i++) {
    const Capabilities c = examineDevice(vulkan.vk, devices[i]);
    known += (known.empty() ? "" : ", ") + std::to_string(i) + " " + c.info.name;
    const bool fits =
        isIndex ? std::to_string(i) == selector : lowerCase(c.info.name).find(lowerCase(selector)) != std::string::npos;
    if (!fits) continue;
    if (c.info.unsupportedReason[0]) {
      unsupported = std::string(c.info.name) + " cannot be used: " + c.info.unsupportedReason;
      unsupportedError = c.driverError != RTC_ERROR_NONE ? c.driverError : RTC_ERROR_UNSUPPORTED_CPU;
      continue;
    }
    if (best && (isBestDiscrete || !c.info.isDiscrete)) continue;
    best = devices[i];
    isBestDiscrete = c.info.isDiscrete;
  }
  if (best) return best;
  if (!unsupported.empty()) throw VulkanError(unsupportedError, "the Vulkan device " + unsupported);
  throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, std::string("there is no Vulkan device ") +
                                                    (isIndex ? "with index '" : "'") + selector +
                                                    "': expected one of " + known);
}

VkDevice createDevice(const InstanceFunctions& vk, VkPhysicalDevice physical, const Capabilities& capabilities) {
  const float priority = 1.0f;
  VkDeviceQueueCreateInfo queue = {VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
  queue.queueFamilyIndex = capabilities.computeFamily;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkPhysicalDeviceVulkan12Features f12 = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
  f12.bufferDeviceAddress = VK_TRUE;
  f12.scalarBlockLayout = VK_TRUE;
  VkPhysicalDeviceFeatures2 features = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
  features.pNext = &f12;
  features.features.shaderFloat64 = capabilities.info.hasFloat64;
  VkPhysicalDeviceRayQueryFeaturesKHR query = {VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};
  query.rayQuery = VK_TRUE;
  VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {
      VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
  structures.pNext = &query;
  structures.accelerationStructure = VK_TRUE;
  std::vector<const char*> extensions;
  if (capabilities.hasHostImport) extensions.push_back(VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME);
  if (capabilities.info.hasRayQuery) {
    extensions.insert(extensions.end(), std::begin(rayQueryExtensions), std::end(rayQueryExtensions));
    f12.pNext = &structures;
  }
  VkDeviceCreateInfo info = {VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
  info.pNext = &features;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = uint32_t(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  VkDevice device = VK_NULL_HANDLE;
  check(vk.CreateDevice(physical, &info, nullptr, &device),
        std::string("opening the device ") + capabilities.info.name);
  return device;
}

} // namespace embree::vulkan
