// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Structs of rtcore_vulkan.h that may grow, and the last member of each in its first version
 * (operations/struct_size.h). This library compiles operations/struct_size.cpp, because libembree3 does not export it.
 */

#include "kernels/cbvh/operations/struct_size.h"

#include <embree3/rtcore_vulkan.h>

namespace embree::core {

CBVH_EXTENSIBLE_STRUCT(RTCVulkanDeviceInfo, hasRayQuery);
CBVH_EXTENSIBLE_STRUCT(RTCVulkanDeviceHandles, hasRayQuery);
CBVH_EXTENSIBLE_STRUCT(RTCVulkanSceneArguments, previousScene);
CBVH_EXTENSIBLE_STRUCT(RTCVulkanSceneStatistics, numUpdatedBoxes);
CBVH_EXTENSIBLE_STRUCT(RTCVulkanTraceTimes, sortSeconds);

} // namespace embree::core
