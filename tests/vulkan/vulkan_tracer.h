// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Traces rays of tests on a Vulkan device. */

#include "validated_device.h"

#include <stdexcept>

namespace programs::test {

inline void intersectOnDevice(const VulkanScene& scene, std::vector<RTCRayHit>& rays) {
  RTCVulkanTrace trace = rtcStartVulkanIntersect(scene.get(), rays.data(), rays.size());
  if (!trace || !rtcFinishVulkanTrace(trace, rays.data(), nullptr))
    throw std::runtime_error("tracing on the Vulkan device failed");
}

inline void occludedOnDevice(const VulkanScene& scene, std::vector<RTCRay>& rays) {
  RTCVulkanTrace trace = rtcStartVulkanOccluded(scene.get(), rays.data(), rays.size());
  if (!trace || !rtcFinishVulkanTrace(trace, rays.data(), nullptr))
    throw std::runtime_error("tracing on the Vulkan device failed");
}

} // namespace programs::test
