// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

// Counts the Vulkan devices. The test is about loading the library; having no device is fine.

#include <embree3/rtcore_vulkan.h>
#include <cstdio>

int main() {
  RTCDevice device = rtcNewDevice(nullptr);
  std::printf("Vulkan devices: %u\n", rtcGetVulkanDevices(device, nullptr, 0));
  rtcReleaseDevice(device);
  return 0;
}
