// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The fixture for tests whose Vulkan device uses Faults. */

#include "faults.h"
#include "small_scenes.h"
#include "support/message_parts.h"

#include <algorithm>

namespace programs::test {

// A result that a test returns from a function, and the expected error of Embree.
struct Fault {
  VkResult result;
  const char* name;
  RTCError error;
};

inline Fault faultOf(const std::string& function) {
  if (function == "MapMemory")
    return {VK_ERROR_MEMORY_MAP_FAILED, "VK_ERROR_MEMORY_MAP_FAILED", RTC_ERROR_OUT_OF_MEMORY};
  if (function == "GetMemoryHostPointerPropertiesEXT")
    return {VK_ERROR_INVALID_EXTERNAL_HANDLE, "VK_ERROR_INVALID_EXTERNAL_HANDLE", RTC_ERROR_UNKNOWN};
  if (function == "CreateInstance" || function == "CreateDevice")
    return {VK_ERROR_INITIALIZATION_FAILED, "VK_ERROR_INITIALIZATION_FAILED", RTC_ERROR_UNKNOWN};
  if (function == "AllocateMemory")
    return {VK_ERROR_OUT_OF_DEVICE_MEMORY, "VK_ERROR_OUT_OF_DEVICE_MEMORY", RTC_ERROR_OUT_OF_MEMORY};
  return {VK_ERROR_OUT_OF_HOST_MEMORY, "VK_ERROR_OUT_OF_HOST_MEMORY", RTC_ERROR_OUT_OF_MEMORY};
}

// True for functions whose failure is not an error: it only affects the cache file, a time or a poll.
inline bool isOptional(const std::string& function) {
  return function == "GetPipelineCacheData" || function == "GetQueryPoolResults" || function == "GetFenceStatus";
}

class VulkanFaults : public VulkanTest {
protected:
  // The fixture's Vulkan device, which uses Faults.
  void SetUp() override {
    VulkanTest::SetUp();
    if (IsSkipped() || HasFatalFailure()) return;
    device.reset();
    faults = std::make_unique<Faults>(vulkan->handles.getInstanceProcAddr);
    vulkan->handles.getInstanceProcAddr = faults->getInstanceProcAddr();
    device = open(vulkan->handles);
    ASSERT_TRUE(device) << embree.message;
  }

  void TearDown() override {
    if (faults) {
      faults->failNothing();
      device.reset();
      EXPECT_EQ(faults->live(), (std::map<std::string, size_t>())) << "objects were not destroyed";
      EXPECT_EQ(faults->strangers(), 0u) << "an object was destroyed twice, or never created";
    }
    VulkanTest::TearDown();
    faults.reset();
  }

  // Opens the device again, with the properties that Faults now reports.
  void reopen() {
    device.reset();
    device = open(vulkan->handles);
    ASSERT_TRUE(device) << embree.message;
  }

  // Makes the first call of a function within a step fail, then the second, until a step has fewer calls. The step
  // returns true on success. Returns the number of calls.
  unsigned failEachCall(const std::string& function, const std::function<bool()>& step) {
    const Fault fault = faultOf(function);
    for (unsigned n = 1;; n++) {
      SCOPED_TRACE(testing::Message() << "vk" << function << " fails, call " << n);
      const std::map<std::string, size_t> before = faults->live();
      embree.message.clear();
      faults->fail(function, n, fault.result);
      const bool done = step();
      faults->failNothing();
      if (!faults->hasFailed()) {
        EXPECT_TRUE(done) << embree.message;
        return n - 1;
      }
      if (isOptional(function)) {
        EXPECT_TRUE(done) << embree.message;
        EXPECT_EQ(embree.takeError(), RTC_ERROR_NONE) << embree.message;
        continue;
      }
      EXPECT_FALSE(done);
      EXPECT_EQ(embree.takeError(), fault.error) << embree.message;
      EXPECT_TRUE(has(embree.message, fault.name)) << embree.message;
      if (function == "AllocateMemory") {
        const std::string size = std::to_string(faults->lastAllocation());
        EXPECT_TRUE(has(embree.message, " " + size + " bytes")) << embree.message;
      }
      EXPECT_EQ(faults->live(), before) << embree.message;
      EXPECT_TRUE(step()) << "the step fails afterwards: " << embree.message;
      EXPECT_EQ(embree.takeError(), RTC_ERROR_NONE) << embree.message;
      if (HasFailure()) return n;
    }
  }

  // Tests every function in turn. Returns the names of the called functions.
  std::vector<std::string> failEverything(const std::function<bool()>& step) {
    std::vector<std::string> called;
    for (const std::string& function : Faults::fallible())
      if (failEachCall(function, step)) called.push_back(function);
    return called;
  }

  std::unique_ptr<Faults> faults;
};

inline void expectAll(const std::vector<std::string>& called, const std::vector<std::string>& expected) {
  for (const std::string& function : expected)
    EXPECT_TRUE(std::find(called.begin(), called.end(), function) != called.end())
        << "vk" << function << " was not called, so it is not tested";
}

} // namespace programs::test
