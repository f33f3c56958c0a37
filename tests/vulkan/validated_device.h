// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A Vulkan device of the test's own, with the validation layer over it where that is installed.
 * What the layer says is kept, and is a failure of the test when the device goes. */

#include "support/scene.h"

#include <embree3/rtcore_vulkan.h>

#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace cbvh::test {

inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Warnings and errors of the validation layer, which may come from any thread.
class Messages
{
public:
  void add(const std::string& message);
  std::vector<std::string> take();   // those since the last call

private:
  std::mutex mutex;
  std::vector<std::string> messages;
};

// What an instance needs so that its messages are kept.
class Validation
{
public:
  // gpuAssisted: shaders are instrumented, too, so that what they read and write is checked.
  explicit Validation(bool gpuAssisted = false);
  Validation(const Validation&) = delete;
  Validation& operator=(const Validation&) = delete;

  // The description of an instance, with the layer. It refers to this object.
  VkInstanceCreateInfo extended(VkInstanceCreateInfo info);

  // Once there is an instance, and before it is destroyed.
  void attach(PFN_vkGetInstanceProcAddr getInstanceProcAddr, VkInstance instance);
  void detach();

  static bool isInstalled();

  Messages messages;

private:
  VkDebugUtilsMessengerCreateInfoEXT messengerInfo{};
  VkValidationFeaturesEXT features{};
  std::vector<VkValidationFeatureEnableEXT> enabled;
  std::vector<const char*> layers, extensions;
  PFN_vkGetInstanceProcAddr getInstanceProcAddr = nullptr;
  VkInstance instance = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger = VK_NULL_HANDLE;
};

// What is enabled of what the device has.
struct DeviceOptions
{
  bool hasFloat64 = true;
  bool hasHostImport = true;
  bool hasRayQuery = true;
  bool isGpuAssisted = false;
};

class ValidatedDevice
{
public:
  using Options = DeviceOptions;

  // Why there is no device to test with, or "".
  static std::string missing();

  // Throws std::runtime_error with what failed.
  explicit ValidatedDevice(const Options& options = Options());

  // Everything that was made with it is gone by now. Fails the test if there are messages.
  ~ValidatedDevice();
  ValidatedDevice(const ValidatedDevice&) = delete;
  ValidatedDevice& operator=(const ValidatedDevice&) = delete;

  // For rtcNewVulkanDeviceFromHandles.
  RTCVulkanHandles handles{};

  // Destroys it now. Returns what the layer has said since the beginning, of objects that were left, too.
  std::vector<std::string> destroy();

  Validation validation;
  std::string name;

private:
  void open(const Options& options);
};

// Points the library at a folder of the tests for its compiled shaders, not at the user's.
void useCacheFolderOfTests();

// --- objects of the library that are released by themselves ---------------------------------

struct VulkanRelease
{
  void operator()(RTCVulkanDevice device) const { rtcReleaseVulkanDevice(device); }
  void operator()(RTCVulkanScene scene) const { rtcReleaseVulkanScene(scene); }
};
using VulkanDevice = std::unique_ptr<RTCVulkanDeviceTy, VulkanRelease>;
using VulkanScene = std::unique_ptr<RTCVulkanSceneTy, VulkanRelease>;

inline VulkanScene newVulkanScene(const VulkanDevice& device, RTCScene scene, RTCVulkanMemory memory = RTC_VULKAN_MEMORY_AUTO)
{
  RTCVulkanSceneArguments args = {};
  args.memory = memory;
  return VulkanScene(rtcNewVulkanScene(device.get(), scene, &args));
}

// For ray queries.
inline VulkanScene newQueryScene(const VulkanDevice& device, RTCScene scene, RTCVulkanScene previous = nullptr)
{
  RTCVulkanSceneArguments args = {};
  args.traversal = RTC_VULKAN_TRAVERSAL_RAY_QUERY;
  args.previous = previous;
  return VulkanScene(rtcNewVulkanScene(device.get(), scene, &args));
}

// --- fixture ---------------------------------------------------------------------------------

// An Embree device, and a Vulkan device that has been handed to the library. Skipped if there is none.
class VulkanTest : public testing::Test
{
protected:
  void SetUp() override;
  void TearDown() override;

  // Another one on the same VkDevice.
  VulkanDevice open(const RTCVulkanHandles& handles) { return VulkanDevice(rtcNewVulkanDeviceFromHandles(embree, &handles)); }

  // Errors that the test has not taken fail it.
  Device embree;
  std::unique_ptr<ValidatedDevice> vulkan;
  VulkanDevice device;
};

} // namespace cbvh::test
