// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Opening devices: missing features, the machine's loader and drivers, and the file of compiled shaders. */

#include "faults_fixture.h"

#include <vulkan/vulkan.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

namespace programs::test { namespace {

using VulkanOpening = VulkanFaults;

// --- devices with missing features -----------------------------------------------------------------

TEST_F(VulkanOpening, OldDriversAreRejected) {
  faults->onProperties = [](VkPhysicalDeviceProperties& properties) {
    properties.apiVersion = VK_MAKE_API_VERSION(0, 1, 1, 42);
  };
  EXPECT_FALSE(open(vulkan->handles));
  EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(embree.message, {vulkan->name, " 1.1.42", " 1.2"}));
}

TEST_F(VulkanOpening, MissingFeaturesAreReported) {
  const struct {
    const char* name;
    void (*remove)(VkPhysicalDeviceFeatures2&, VkPhysicalDeviceVulkan12Features&);
  } features[] = {
      {"bufferDeviceAddress",
       [](VkPhysicalDeviceFeatures2&, VkPhysicalDeviceVulkan12Features& f) { f.bufferDeviceAddress = VK_FALSE; }},
      {"scalarBlockLayout",
       [](VkPhysicalDeviceFeatures2&, VkPhysicalDeviceVulkan12Features& f) { f.scalarBlockLayout = VK_FALSE; }},
      {"shaderFloat64",
       [](VkPhysicalDeviceFeatures2& f, VkPhysicalDeviceVulkan12Features&) { f.features.shaderFloat64 = VK_FALSE; }}};
  for (const auto& feature : features) {
    faults->onFeatures = [&](VkPhysicalDeviceFeatures2& f) {
      for (VkBaseOutStructure* p = (VkBaseOutStructure*)&f; p; p = p->pNext)
        if (p->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES)
          feature.remove(f, *(VkPhysicalDeviceVulkan12Features*)p);
    };
    EXPECT_FALSE(open(vulkan->handles)) << feature.name;
    EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(has(embree.message, feature.name) && has(embree.message, vulkan->name)) << embree.message;
  }
  faults->onFeatures = nullptr;

  RTCVulkanDeviceHandles handles = vulkan->handles;
  handles.hasHostImport = 1;
  faults->onExtensions = [](std::vector<VkExtensionProperties>& extensions) { extensions.clear(); };
  EXPECT_FALSE(open(handles));
  EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(has(embree.message, "VK_EXT_external_memory_host")) << embree.message;
}

// Vulkan guarantees workgroups of 128 threads. The sort of rays needs more.
TEST_F(VulkanOpening, DeviceWithSmallWorkgroupsTracesButDoesNotSort) {
  void (*const smaller[])(VkPhysicalDeviceLimits&) = {
      [](VkPhysicalDeviceLimits& limits) { limits.maxComputeWorkGroupInvocations = 128; },
      [](VkPhysicalDeviceLimits& limits) { limits.maxComputeWorkGroupSize[0] = 128; }};
  const SmallScene scene(embree, RTC_COMPRESSION_CVERT);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  for (const auto& shrink : smaller) {
    faults->onProperties = [&](VkPhysicalDeviceProperties& properties) { shrink(properties.limits); };
    device = open(vulkan->handles);
    ASSERT_TRUE(device) << embree.message;
    const VulkanScene uploaded = newVulkanScene(device, scene);
    ASSERT_TRUE(uploaded) << embree.message;
    rtcSetVulkanSceneRaySorting(uploaded.get(), true);
    EXPECT_FALSE(rtcStartVulkanIntersect(uploaded.get(), rays.data(), rays.size()));
    EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_OPERATION);
    EXPECT_TRUE(containsInOrder(embree.message, {vulkan->name, " 128 ", " 256 "}));
    rtcSetVulkanSceneRaySorting(uploaded.get(), false);
    expectAsOnTheCPU(scene, rays, traceAll(uploaded.get(), rays));
  }
}

// Features that are not enabled are not used.
TEST_F(VulkanOpening, DeviceWithoutOptionalFeaturesSupportsOtherScenes) {
  device.reset();
  faults.reset();
  vulkan.reset();
  DeviceOptions options;
  options.hasFloat64 = options.hasHostImport = false;
  vulkan = std::make_unique<ValidatedDevice>(options);
  RTCVulkanDeviceHandles withImport = vulkan->handles;
  withImport.hasHostImport = 1;
  EXPECT_FALSE(open(withImport));
  EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_TRUE(has(embree.message, "VK_EXT_external_memory_host")) << embree.message;
  device = open(vulkan->handles);
  ASSERT_TRUE(device) << embree.message;
  const SmallScene leaf(embree), vert(embree, RTC_COMPRESSION_CVERT);
  EXPECT_FALSE(newVulkanScene(device, leaf, RTC_VULKAN_MEMORY_IMPORT));
  EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_TRUE(has(embree.message, "VK_EXT_external_memory_host")) << embree.message;
  const VulkanScene uploaded = newVulkanScene(device, leaf);
  ASSERT_TRUE(uploaded) << embree.message;
  const std::vector<RTCRayHit> rays = raysFromAbove();
  expectAsOnTheCPU(leaf, rays, traceAll(uploaded.get(), rays));

  // cVERT computes exact signs with integers
  const VulkanScene exact = newVulkanScene(device, vert);
  ASSERT_TRUE(exact) << embree.message;
  expectAsOnTheCPU(vert, rays, traceAll(exact.get(), rays));
}

// --- the library's own loading of Vulkan ---------------------------------------------------------

// rtcNewVulkanDevice and rtcGetVulkanDevices with Faults.
class VulkanLoader : public VulkanFaults {
protected:
  void SetUp() override {
    useCacheFolderOfTests();
    if (const std::string reason = ValidatedDevice::missing(); !reason.empty()) GTEST_SKIP() << reason;
    setenv("EMBREE_VULKAN_LOADER", TEST_LOADER, 1);
    faults = std::make_unique<Faults>(vkGetInstanceProcAddr);
    faults->onInstanceInfo = [&](const VkInstanceCreateInfo& info) { return validation.extended(info); };
    faults->onInstance = [&](VkInstance instance) { validation.attach(vkGetInstanceProcAddr, instance); };
    faults->onInstanceEnd = [&](VkInstance) { validation.detach(); };
  }

  void TearDown() override {
    VulkanFaults::TearDown();
    unsetenv("EMBREE_VULKAN_LOADER");
    for (const std::string& message : validation.messages.take()) ADD_FAILURE() << message;
  }

  VulkanDevice openOwn(const char* selector = nullptr) { return VulkanDevice(rtcNewVulkanDevice(embree, selector)); }

  Validation validation;
};

TEST_F(VulkanLoader, OwnDeviceTracesUnderValidation) {
  device = openOwn();
  ASSERT_TRUE(device) << embree.message;
  EXPECT_EQ(faults->live()["instance"], 1u);
  EXPECT_EQ(faults->live()["device"], 1u);
  SmallScene scene(embree, RTC_COMPRESSION_CVERT);
  const VulkanScene uploaded = newVulkanScene(device, scene);
  ASSERT_TRUE(uploaded) << embree.message;
  const std::vector<RTCRayHit> rays = raysFromAbove();
  expectAsOnTheCPU(scene, rays, traceAll(uploaded.get(), rays));
}

TEST_F(VulkanLoader, OpeningDoesNotLeak) {
  // one device: if one of several fails, another is opened
  faults->onDevices = [](std::vector<VkPhysicalDevice>& devices) { devices.resize(1); };
  expectAll(failEverything([&] { return bool(openOwn()); }),
            {"CreateInstance", "EnumeratePhysicalDevices", "EnumerateDeviceExtensionProperties", "CreateDevice",
             "CreateCommandPool"});
}

TEST_F(VulkanLoader, MissingFunctionsAreReported) {
  for (const char* name : {"CreateInstance", "EnumeratePhysicalDevices", "GetPhysicalDeviceProperties2",
                           "GetPhysicalDeviceFeatures2", "CreateDevice", "GetDeviceProcAddr", "GetBufferDeviceAddress",
                           "GetMemoryHostPointerPropertiesEXT", "QueueSubmit"}) {
    SCOPED_TRACE(name);
    faults->hide(name);
    EXPECT_FALSE(openOwn());
    EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_OPERATION);
    EXPECT_TRUE(has(embree.message, std::string("vk") + name)) << embree.message;
    faults->show(name);
    EXPECT_EQ(faults->live(), (std::map<std::string, size_t>()));
  }
  EXPECT_TRUE(openOwn()) << embree.message;
}

TEST_F(VulkanLoader, ListingDevicesDoesNotLeak) {
  EXPECT_GE(rtcGetVulkanDevices(embree, nullptr, 0), 1u);
  EXPECT_TRUE(faults->live().empty());
  faults->fail("EnumeratePhysicalDevices", 1, VK_ERROR_OUT_OF_HOST_MEMORY);
  EXPECT_EQ(rtcGetVulkanDevices(embree, nullptr, 0), 0u);
  EXPECT_EQ(embree.takeError(), RTC_ERROR_OUT_OF_MEMORY);
  EXPECT_TRUE(faults->live().empty());
}

TEST_F(VulkanLoader, MachineWithoutADeviceIsAnError) {
  faults->onDevices = [](std::vector<VkPhysicalDevice>& devices) { devices.clear(); };
  EXPECT_EQ(rtcGetVulkanDevices(embree, nullptr, 0), 0u);
  EXPECT_EQ(embree.takeError(), RTC_ERROR_NONE) << "an empty list is not an error";
  EXPECT_FALSE(openOwn());
  EXPECT_EQ(embree.takeError(), RTC_ERROR_UNSUPPORTED_CPU);
  EXPECT_TRUE(has(embree.message, "device")) << embree.message;
}

TEST_F(VulkanLoader, UnusableDeviceIsListedWithTheReasonAndNotChosen) {
  faults->onProperties = [](VkPhysicalDeviceProperties& properties) {
    properties.apiVersion = VK_MAKE_API_VERSION(0, 1, 0, 3);
  };
  std::vector<RTCVulkanDeviceInfo> infos(rtcGetVulkanDevices(embree, nullptr, 0));
  ASSERT_EQ(rtcGetVulkanDevices(embree, infos.data(), unsigned(infos.size())), infos.size());
  for (const RTCVulkanDeviceInfo& info : infos)
    EXPECT_TRUE(containsInOrder(info.unsupportedReason, {" 1.0.3", " 1.2"})) << info.name;
  for (const std::string& selector : {std::string(), std::string("0"), std::string(infos[0].name)}) {
    EXPECT_FALSE(openOwn(selector.c_str()));
    EXPECT_EQ(embree.takeError(), RTC_ERROR_UNSUPPORTED_CPU);
    EXPECT_TRUE(containsInOrder(embree.message, {infos[0].name, " 1.0.3", " 1.2"}));
  }
}

// Two devices. The driver of one fails while the device is examined.
TEST_F(VulkanLoader, BrokenDriverDoesNotHideOtherDevices) {
  const char* const function = "EnumerateDeviceExtensionProperties";
  faults->onDevices = [](std::vector<VkPhysicalDevice>& devices) { devices.assign(2, VkPhysicalDevice(devices[0])); };
  RTCVulkanDeviceInfo infos[2];
  const unsigned before = faults->calls(function);
  ASSERT_EQ(rtcGetVulkanDevices(embree, infos, 2), 2u);
  const unsigned callsPerDevice = (faults->calls(function) - before) / 2;
  ASSERT_GT(callsPerDevice, 0u);
  const std::string name = infos[0].name;
  for (unsigned broken : {0u, 1u}) {
    SCOPED_TRACE(broken);
    const auto failOnce = [&] { faults->fail(function, 1 + broken * callsPerDevice, VK_ERROR_INITIALIZATION_FAILED); };
    failOnce();
    EXPECT_EQ(rtcGetVulkanDevices(embree, infos, 2), 2u);
    EXPECT_TRUE(faults->hasFailed());
    EXPECT_EQ(embree.takeError(), RTC_ERROR_NONE) << embree.message;
    EXPECT_TRUE(has(infos[broken].unsupportedReason, "VK_ERROR_INITIALIZATION_FAILED"))
        << infos[broken].unsupportedReason;
    EXPECT_EQ(infos[broken].name, name);
    EXPECT_STREQ(infos[1 - broken].unsupportedReason, "");

    failOnce();
    EXPECT_TRUE(openOwn()) << embree.message;
    EXPECT_TRUE(faults->hasFailed());
    EXPECT_EQ(embree.takeError(), RTC_ERROR_NONE) << embree.message;

    failOnce();
    EXPECT_FALSE(openOwn(std::to_string(broken).c_str()));
    EXPECT_EQ(embree.takeError(), RTC_ERROR_UNKNOWN);
    EXPECT_TRUE(has(embree.message, name) && has(embree.message, "VK_ERROR_INITIALIZATION_FAILED")) << embree.message;
  }
}

// Two devices; the second is discrete.
TEST_F(VulkanLoader, DiscreteDevicesAreChosenFirst) {
  int calls = 0;
  faults->onDevices = [](std::vector<VkPhysicalDevice>& devices) { devices.push_back(devices[0]); };
  faults->onProperties = [&](VkPhysicalDeviceProperties& properties) {
    if (calls++ % 2) {
      properties.deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
      std::snprintf(properties.deviceName, sizeof(properties.deviceName), "Discrete");
    }
  };
  RTCVulkanDeviceInfo infos[2];
  if (rtcGetVulkanDevices(embree, infos, 2) != 2) GTEST_SKIP() << "the machine has more devices";
  EXPECT_FALSE(infos[0].isDiscrete);
  EXPECT_TRUE(infos[1].isDiscrete);
  // the third and fifth calls belong to the opened device
  for (const char* selector : {"", "discrete", "1"}) {
    calls = 0;
    faults->onProperties = [&](VkPhysicalDeviceProperties& properties) {
      if (calls++) {
        properties.deviceType = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
        std::snprintf(properties.deviceName, sizeof(properties.deviceName), "Discrete");
      }
    };
    const VulkanDevice opened = openOwn(selector);
    ASSERT_TRUE(opened) << embree.message;
    RTCVulkanDeviceInfo info;
    rtcGetVulkanDeviceInfo(opened.get(), &info);
    EXPECT_STREQ(info.name, "Discrete");
    EXPECT_TRUE(info.isDiscrete);
  }
}

TEST_F(VulkanLoader, MissingLoaderIsReported) {
  setenv("EMBREE_VULKAN_LOADER", "/nowhere/libvulkan.so.1", 1);
  EXPECT_FALSE(openOwn());
  EXPECT_EQ(embree.takeError(), RTC_ERROR_UNSUPPORTED_CPU);
  EXPECT_TRUE(has(embree.message, "/nowhere/libvulkan.so.1") && has(embree.message, "EMBREE_VULKAN_LOADER"))
      << embree.message;
  EXPECT_EQ(rtcGetVulkanDevices(embree, nullptr, 0), 0u);
  EXPECT_EQ(embree.takeError(), RTC_ERROR_UNSUPPORTED_CPU);
  // a library without vkGetInstanceProcAddr
  setenv("EMBREE_VULKAN_LOADER", "libm.so.6", 1);
  EXPECT_FALSE(openOwn());
  EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_TRUE(has(embree.message, "vkGetInstanceProcAddr")) << embree.message;
  setenv("EMBREE_VULKAN_LOADER", "", 1);
  EXPECT_TRUE(openOwn()) << "an empty name selects the default: " << embree.message;
}

TEST_F(VulkanLoader, MachineWithoutADriverIsAnError) {
  for (const char* variable : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}) setenv(variable, "/nowhere/none.json", 1);
  EXPECT_FALSE(openOwn());
  EXPECT_EQ(embree.takeError(), RTC_ERROR_UNSUPPORTED_CPU);
  EXPECT_TRUE(containsInOrder(embree.message, {"driver", "VK_ERROR_INCOMPATIBLE_DRIVER"}));
  EXPECT_EQ(rtcGetVulkanDevices(embree, nullptr, 0), 0u);
  EXPECT_EQ(embree.takeError(), RTC_ERROR_UNSUPPORTED_CPU);
  for (const char* variable : {"VK_DRIVER_FILES", "VK_ICD_FILENAMES"}) unsetenv(variable);
  EXPECT_TRUE(openOwn()) << "with a driver again: " << embree.message;
}

// --- compiled shaders ---------------------------------------------------------------------------

// A damaged file, or something else than a file, is ignored. A failed write is not an error.
TEST_F(VulkanOpening, CompiledShadersAreStoredAndReadIfIntact) {
  namespace fs = std::filesystem;
  const fs::path folder = fs::path(testing::TempDir()) / ("vulkan_faults_cache." + std::to_string(getpid()));
  fs::remove_all(folder);
  setenv("XDG_CACHE_HOME", folder.c_str(), 1);
  reopen();
  EXPECT_EQ(faults->lastCache(), 0u);
  reopen(); // the previous device has written the file
  const std::vector<fs::path> files(fs::directory_iterator(folder / "embree-cbvh"), fs::directory_iterator());
  ASSERT_EQ(files.size(), 1u) << "one file per driver, and no other files";
  const size_t whole = faults->lastCache();
  ASSERT_GT(whole, 0u);
  EXPECT_LT(whole, fs::file_size(files[0])) << "with a checksum";

  const auto damage = [&](const std::function<void(const fs::path&)>& how) {
    fs::copy_file(files[0], folder / "copy", fs::copy_options::overwrite_existing);
    how(files[0]);
    device.reset();
    how(files[0]); // modifies the written file
    device = open(vulkan->handles);
    EXPECT_TRUE(device) << embree.message;
    const size_t read = faults->lastCache();
    fs::remove_all(files[0]);
    fs::copy_file(folder / "copy", files[0]);
    return read;
  };
  EXPECT_EQ(damage([](const fs::path&) {}), whole);
  EXPECT_EQ(damage([](const fs::path& file) { fs::resize_file(file, 0); }), 0u);
  EXPECT_EQ(damage([](const fs::path& file) { fs::resize_file(file, 5); }), 0u);
  EXPECT_EQ(damage([&](const fs::path& file) { fs::resize_file(file, whole); }), 0u);
  EXPECT_EQ(damage([&](const fs::path& file) { fs::resize_file(file, whole + 100); }), 0u);
  EXPECT_EQ(damage([](const fs::path& file) {
              std::fstream f(file, std::ios::in | std::ios::out | std::ios::binary);
              f.seekp(20);
              f.put(char(0x5A));
            }),
            0u);
  EXPECT_EQ(damage([](const fs::path& file) {
              fs::remove_all(file);
              fs::create_directories(file / "folder");
            }),
            0u);
  EXPECT_EQ(damage([](const fs::path& file) {
              fs::remove(file);
              fs::create_symlink("/dev/null", file);
            }),
            0u);
  EXPECT_TRUE(fs::is_character_file("/dev/null")) << "a device is replaced";
  EXPECT_EQ(damage([](const fs::path& file) {
              fs::remove(file);
              ASSERT_EQ(mkfifo(file.c_str(), 0600), 0);
            }),
            0u);

  device.reset();
  fs::remove_all(folder);
  for (const char* nowhere : {"/dev/null", "/proc/nowhere", ""}) {
    setenv("XDG_CACHE_HOME", nowhere, 1);
    const std::string home = getenv("HOME") ? getenv("HOME") : "";
    unsetenv("HOME");
    const VulkanDevice opened = open(vulkan->handles);
    EXPECT_TRUE(opened) << embree.message;
    EXPECT_EQ(faults->lastCache(), 0u);
    if (!home.empty()) setenv("HOME", home.c_str(), 1);
  }
  useCacheFolderOfTests();
  reopen();
}

}} // namespace programs::test
