// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A Vulkan device with the validation layer if it is installed, whose messages fail the test when the device is
 * destroyed. */

#include "support/scene.h"

#include <embree3/rtcore_vulkan.h>

#include <gtest/gtest.h>

#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace programs::test {

inline bool has(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Warnings and errors of the validation layer, from any thread.
class Messages {
public:
  void add(const std::string& message);
  std::vector<std::string> take(); // messages since the last call

private:
  std::mutex mutex;
  std::vector<std::string> messages;
};

// Adds the validation layer and its messenger to an instance.
class Validation {
public:
  // gpuAssisted: instruments shaders to check their memory accesses.
  explicit Validation(bool gpuAssisted = false);
  Validation(const Validation&) = delete;
  Validation& operator=(const Validation&) = delete;

  // The result refers to this object.
  VkInstanceCreateInfo extended(VkInstanceCreateInfo info);

  // Call after the instance was created, and before it is destroyed.
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

struct DeviceOptions {
  bool hasFloat64 = true;
  bool hasHostImport = true;
  bool hasRayQuery = true;
  bool isGpuAssisted = false;
};

class ValidatedDevice {
public:
  using Options = DeviceOptions;

  // Returns the reason why there is no device for tests, or "".
  static std::string missing();

  // Throws std::runtime_error with the name of the failed call.
  explicit ValidatedDevice(const Options& options = Options());

  // All objects of the device must have been destroyed. Fails the test if there are messages.
  ~ValidatedDevice();
  ValidatedDevice(const ValidatedDevice&) = delete;
  ValidatedDevice& operator=(const ValidatedDevice&) = delete;

  // Handles for rtcNewVulkanDeviceFromHandles.
  RTCVulkanDeviceHandles handles{};

  // Destroys the device now. Returns all messages of the layer.
  std::vector<std::string> destroy();

  Validation validation;
  std::string name;

private:
  void open(const Options& options);
};

// The library then stores compiled shaders in a folder of the tests.
void useCacheFolderOfTests();

// --- owners of the library's objects ----------------------------------------------------------

struct VulkanRelease {
  void operator()(RTCVulkanDevice device) const { rtcReleaseVulkanDevice(device); }
  void operator()(RTCVulkanScene scene) const { rtcReleaseVulkanScene(scene); }
};
using VulkanDevice = std::unique_ptr<RTCVulkanDeviceTy, VulkanRelease>;
using VulkanScene = std::unique_ptr<RTCVulkanSceneTy, VulkanRelease>;

inline VulkanScene newVulkanScene(const VulkanDevice& device, RTCScene scene,
                                  RTCVulkanMemory memory = RTC_VULKAN_MEMORY_AUTO) {
  RTCVulkanSceneArguments args = {};
  args.memory = memory;
  return VulkanScene(rtcNewVulkanScene(device.get(), scene, &args));
}

// A scene for ray queries.
inline VulkanScene newQueryScene(const VulkanDevice& device, RTCScene scene, RTCVulkanScene previous = nullptr) {
  RTCVulkanSceneArguments args = {};
  args.traversal = RTC_VULKAN_TRAVERSAL_RAY_QUERY;
  args.previousScene = previous;
  return VulkanScene(rtcNewVulkanScene(device.get(), scene, &args));
}

// --- fixture ---------------------------------------------------------------------------------

// An Embree device, and a Vulkan device that the library uses.
struct VulkanDevices {
  // Opens both. Fails the test if this fails.
  void openAll();

  // Opens another library device on a VkDevice.
  VulkanDevice open(const RTCVulkanDeviceHandles& handles) {
    return VulkanDevice(rtcNewVulkanDeviceFromHandles(embree, &handles));
  }

  Device embree;
  std::unique_ptr<ValidatedDevice> vulkan;
  VulkanDevice device;
};

// Opens devices for each test. Skips the test if there is none. Errors that the test does not retrieve fail the test.
class VulkanTest : public testing::Test, protected VulkanDevices {
protected:
  void SetUp() override;
  void TearDown() override;
};

/* As VulkanTest, but all tests of the suite share the devices, because compiling the shaders takes longer than most
 * tests. Messages of the validation layer fail the test that causes them; messages about objects that still exist when
 * the devices are destroyed fail the suite. */
class SharedVulkanTest : public testing::Test {
  static std::unique_ptr<VulkanDevices> shared;

protected:
  static void SetUpTestSuite();
  static void TearDownTestSuite();
  void SetUp() override;
  void TearDown() override;

  // Skips the test. Use it if the reason skips all tests of the program: ctest recognizes the message.
  static void skipProgram(const std::string& reason);

  VulkanDevice open(const RTCVulkanDeviceHandles& handles) { return shared->open(handles); }

  Device& embree = shared->embree;
  const std::unique_ptr<ValidatedDevice>& vulkan = shared->vulkan;
  const VulkanDevice& device = shared->device;
};

} // namespace programs::test
