// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "validated_device.h"

#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>

/* Options of a sanitizer: it cannot attribute memory of the loader and the driver once they are unloaded. faults.h
 * counts the Vulkan objects of the library. */
extern "C" const char* __asan_default_options();
extern "C" const char* __asan_default_options() { return "detect_leaks=0"; }

namespace programs::test {
namespace {

constexpr const char* layerName = "VK_LAYER_KHRONOS_validation";

/* True if the layer reports how it was set up for instrumentation, as version 1.4 does: that core checks are enabled as
 * well, and features and limits that it changes for its own purposes. */
bool isAboutSetUp(const std::string& name, const std::string& message) {
  return (name == "VALIDATION-SETTINGS" && has(message, "Core Check")) ||
         (name == "WARNING-GPU-Assisted-Validation" && (has(message, "Internal Warning: Forcing VkPhysicalDevice") ||
                                                        has(message, "Internal Warning: Setting VkPhysicalDevice")));
}

VKAPI_ATTR VkBool32 VKAPI_CALL keep(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                                    const VkDebugUtilsMessengerCallbackDataEXT* data, void* messages) {
  const std::string name = data->pMessageIdName ? data->pMessageIdName : "";
  const std::string message = data->pMessage ? data->pMessage : "";
  if (!isAboutSetUp(name, message)) static_cast<Messages*>(messages)->add(name + ": " + message);
  return VK_FALSE;
}

void check(VkResult result, const char* doing) {
  if (result != VK_SUCCESS)
    throw std::runtime_error(std::string(doing) + " failed: VkResult " + std::to_string(result));
}

// Returns all items of a Vulkan function that lists some.
template<typename T, typename List>
std::vector<T> listed(const List& list) {
  uint32_t count = 0;
  if (list(&count, nullptr) != VK_SUCCESS) return {};
  std::vector<T> items(count);
  if (list(&count, items.data()) < VK_SUCCESS) return {};
  items.resize(count);
  return items;
}

std::vector<VkPhysicalDevice> devicesOf(VkInstance instance) {
  return listed<VkPhysicalDevice>(
      [&](uint32_t* count, VkPhysicalDevice* devices) { return vkEnumeratePhysicalDevices(instance, count, devices); });
}

bool hasExtension(VkPhysicalDevice device, const char* name) {
  const auto extensions = listed<VkExtensionProperties>([&](uint32_t* count, VkExtensionProperties* to) {
    return vkEnumerateDeviceExtensionProperties(device, nullptr, count, to);
  });
  return std::any_of(extensions.begin(), extensions.end(),
                     [&](const VkExtensionProperties& e) { return std::string(e.extensionName) == name; });
}

VkInstance newInstance(Validation* validation) {
  VkApplicationInfo application = {};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.apiVersion = VK_API_VERSION_1_2;
  VkInstanceCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  info.pApplicationInfo = &application;
  if (validation) info = validation->extended(info);
  VkInstance instance = VK_NULL_HANDLE;
  check(vkCreateInstance(&info, nullptr, &instance), "vkCreateInstance");
  return instance;
}

// Extensions that the library requires of a device according to its header.
const char* const rayQueryExtensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME, VK_KHR_RAY_QUERY_EXTENSION_NAME,
                                          VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};

bool hasRayQuery(VkPhysicalDevice device) {
  return std::all_of(std::begin(rayQueryExtensions), std::end(rayQueryExtensions),
                     [&](const char* name) { return hasExtension(device, name); });
}

bool isUsable(VkPhysicalDevice device) {
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(device, &properties);
  if (properties.apiVersion < VK_API_VERSION_1_2) return false;
  VkPhysicalDeviceVulkan12Features features12 = {};
  features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  VkPhysicalDeviceFeatures2 features = {};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &features12;
  vkGetPhysicalDeviceFeatures2(device, &features);
  return features12.bufferDeviceAddress && features12.scalarBlockLayout && features.features.shaderFloat64;
}

} // namespace

// --- messages --------------------------------------------------------------------------------

void Messages::add(const std::string& message) {
  std::lock_guard<std::mutex> lock(mutex);
  messages.push_back(message);
}

std::vector<std::string> Messages::take() {
  std::lock_guard<std::mutex> lock(mutex);
  return std::exchange(messages, {});
}

Validation::Validation(bool gpuAssisted) : enabled{VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT} {
  if (gpuAssisted)
    enabled.insert(enabled.end(), {VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_EXT,
                                   VK_VALIDATION_FEATURE_ENABLE_GPU_ASSISTED_RESERVE_BINDING_SLOT_EXT});
  messengerInfo.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
  messengerInfo.messageSeverity =
      VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
  messengerInfo.messageType =
      VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
  messengerInfo.pfnUserCallback = keep;
  messengerInfo.pUserData = &messages;
  features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
}

VkInstanceCreateInfo Validation::extended(VkInstanceCreateInfo info) {
  if (!isInstalled()) return info;
  layers.assign(info.ppEnabledLayerNames, info.ppEnabledLayerNames + info.enabledLayerCount);
  layers.push_back(layerName);
  extensions.assign(info.ppEnabledExtensionNames, info.ppEnabledExtensionNames + info.enabledExtensionCount);
  extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
  // this messenger reports errors of vkCreateInstance and vkDestroyInstance
  messengerInfo.pNext = info.pNext;
  features.pNext = &messengerInfo;
  features.enabledValidationFeatureCount = uint32_t(enabled.size());
  features.pEnabledValidationFeatures = enabled.data();
  info.pNext = &features;
  info.enabledLayerCount = uint32_t(layers.size());
  info.ppEnabledLayerNames = layers.data();
  info.enabledExtensionCount = uint32_t(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  return info;
}

void Validation::attach(PFN_vkGetInstanceProcAddr from, VkInstance to) {
  if (!isInstalled()) return;
  getInstanceProcAddr = from;
  instance = to;
  const auto create =
      PFN_vkCreateDebugUtilsMessengerEXT(getInstanceProcAddr(instance, "vkCreateDebugUtilsMessengerEXT"));
  VkDebugUtilsMessengerCreateInfoEXT info = messengerInfo;
  info.pNext = nullptr;
  check(create(instance, &info, nullptr, &messenger), "vkCreateDebugUtilsMessengerEXT");
}

void Validation::detach() {
  if (!messenger) return;
  const auto destroy =
      PFN_vkDestroyDebugUtilsMessengerEXT(getInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT"));
  destroy(instance, messenger, nullptr);
  messenger = VK_NULL_HANDLE;
}

bool Validation::isInstalled() {
  static const bool installed = [] {
    const std::vector<VkLayerProperties> layers = listed<VkLayerProperties>(vkEnumerateInstanceLayerProperties);
    const bool found = std::any_of(layers.begin(), layers.end(), [](const VkLayerProperties& layer) {
      return std::string(layer.layerName) == layerName;
    });
    if (!found) std::printf("%s is not installed: no validation\n", layerName);
    return found;
  }();
  return installed;
}

// --- devices ---------------------------------------------------------------------------------

std::string ValidatedDevice::missing() {
  static const std::string reason = []() -> std::string {
    VkInstance instance;
    try {
      instance = newInstance(nullptr);
    } catch (const std::exception& error) { return std::string("no Vulkan driver: ") + error.what(); }
    const std::vector<VkPhysicalDevice> devices = devicesOf(instance);
    const bool found = std::any_of(devices.begin(), devices.end(), isUsable);
    vkDestroyInstance(instance, nullptr);
    return found ? ""
                 : "of " + std::to_string(devices.size()) +
                       " Vulkan devices, none supports Vulkan 1.2, bufferDeviceAddress, scalarBlockLayout and "
                       "shaderFloat64";
  }();
  return reason;
}

ValidatedDevice::ValidatedDevice(const Options& options) : validation(options.isGpuAssisted) {
  try {
    open(options);
  } catch (...) {
    destroy();
    throw;
  }
}

void ValidatedDevice::open(const Options& options) {
  handles.getInstanceProcAddr = vkGetInstanceProcAddr;
  handles.instance = newInstance(&validation);
  validation.attach(vkGetInstanceProcAddr, handles.instance);

  const std::vector<VkPhysicalDevice> devices = devicesOf(handles.instance);
  const auto found = std::find_if(devices.begin(), devices.end(), isUsable);
  if (found == devices.end()) throw std::runtime_error("no Vulkan device");
  handles.physicalDevice = *found;
  VkPhysicalDeviceProperties properties;
  vkGetPhysicalDeviceProperties(handles.physicalDevice, &properties);
  name = properties.deviceName;

  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(handles.physicalDevice, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(handles.physicalDevice, &count, families.data());
  while (handles.queueFamily < count && !(families[handles.queueFamily].queueFlags & VK_QUEUE_COMPUTE_BIT))
    handles.queueFamily++;

  std::vector<const char*> extensions;
  handles.hasHostImport =
      options.hasHostImport && hasExtension(handles.physicalDevice, VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME);
  if (handles.hasHostImport) extensions.push_back(VK_EXT_EXTERNAL_MEMORY_HOST_EXTENSION_NAME);
  handles.hasFloat64 = options.hasFloat64;

  const float priority = 1;
  VkDeviceQueueCreateInfo queue = {};
  queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
  queue.queueFamilyIndex = handles.queueFamily;
  queue.queueCount = 1;
  queue.pQueuePriorities = &priority;
  VkPhysicalDeviceVulkan12Features features12 = {};
  features12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  features12.bufferDeviceAddress = VK_TRUE;
  features12.scalarBlockLayout = VK_TRUE;
  VkPhysicalDeviceFeatures2 features = {};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &features12;
  features.features.shaderFloat64 = options.hasFloat64;
  if (options.isGpuAssisted) // features that the instrumentation requires for stores and addresses
    features.features.fragmentStoresAndAtomics = features.features.vertexPipelineStoresAndAtomics =
        features.features.shaderInt64 = VK_TRUE;
  VkPhysicalDeviceRayQueryFeaturesKHR query = {};
  query.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR;
  VkPhysicalDeviceAccelerationStructureFeaturesKHR structures = {};
  structures.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR;
  structures.pNext = &query;
  if (options.hasRayQuery && hasRayQuery(handles.physicalDevice)) {
    handles.hasRayQuery = 1;
    structures.accelerationStructure = query.rayQuery = VK_TRUE;
    features12.pNext = &structures;
    extensions.insert(extensions.end(), std::begin(rayQueryExtensions), std::end(rayQueryExtensions));
  }
  VkDeviceCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  info.pNext = &features;
  info.queueCreateInfoCount = 1;
  info.pQueueCreateInfos = &queue;
  info.enabledExtensionCount = uint32_t(extensions.size());
  info.ppEnabledExtensionNames = extensions.data();
  check(vkCreateDevice(handles.physicalDevice, &info, nullptr, &handles.device), "vkCreateDevice");
  vkGetDeviceQueue(handles.device, handles.queueFamily, 0, &handles.queue);
}

std::vector<std::string> ValidatedDevice::destroy() {
  // the layer reports objects that were not destroyed here
  if (handles.device) vkDestroyDevice(handles.device, nullptr);
  validation.detach();
  if (handles.instance) vkDestroyInstance(handles.instance, nullptr);
  handles = RTCVulkanDeviceHandles();
  return validation.messages.take();
}

ValidatedDevice::~ValidatedDevice() {
  for (const std::string& message : destroy()) ADD_FAILURE() << message;
}

void useCacheFolderOfTests() { setenv("XDG_CACHE_HOME", CACHE_FOLDER, 1); }

// --- fixture ---------------------------------------------------------------------------------

void VulkanDevices::openAll() {
  vulkan = std::make_unique<ValidatedDevice>();
  device = open(vulkan->handles);
  ASSERT_TRUE(device) << embree.message;
}

void VulkanTest::SetUp() {
  useCacheFolderOfTests();
  if (const std::string reason = ValidatedDevice::missing(); !reason.empty()) GTEST_SKIP() << reason;
  openAll();
}

void VulkanTest::TearDown() {
  device.reset();
  vulkan.reset();
  EXPECT_EQ(embree.takeError(), RTC_ERROR_NONE) << embree.message;
}

std::unique_ptr<VulkanDevices> SharedVulkanTest::shared;

void SharedVulkanTest::SetUpTestSuite() {
  useCacheFolderOfTests();
  shared = std::make_unique<VulkanDevices>();
  if (ValidatedDevice::missing().empty()) shared->openAll();
}

void SharedVulkanTest::TearDownTestSuite() { shared.reset(); }

void SharedVulkanTest::skipProgram(const std::string& reason) {
  GTEST_SKIP() << "all tests of this program are skipped: " << reason;
}

void SharedVulkanTest::SetUp() {
  if (!vulkan) return skipProgram(ValidatedDevice::missing());
  ASSERT_TRUE(device);
}

void SharedVulkanTest::TearDown() {
  EXPECT_EQ(embree.takeError(), RTC_ERROR_NONE) << embree.message;
  if (!vulkan) return;
  for (const std::string& message : vulkan->validation.messages.take()) ADD_FAILURE() << message;
}

} // namespace programs::test
