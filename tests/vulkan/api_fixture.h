// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The fixture for tests of reported errors. */

#include "small_scenes.h"
#include "support/message_parts.h"

namespace programs::test {

class VulkanAPI : public VulkanTest {
protected:
  void expectMessage(const std::vector<std::string>& parts) { EXPECT_TRUE(containsInOrder(embree.message, parts)); }

  void expectError(RTCError code, const std::vector<std::string>& parts) {
    EXPECT_EQ(embree.takeError(), code) << embree.message;
    expectMessage(parts);
  }

  void expectNoError() { EXPECT_EQ(embree.takeError(), RTC_ERROR_NONE) << embree.message; }

  VulkanScene upload(RTCScene scene, RTCVulkanMemory memory = RTC_VULKAN_MEMORY_AUTO) {
    return newVulkanScene(device, scene, memory);
  }
};

} // namespace programs::test
