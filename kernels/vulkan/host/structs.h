// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Structs of rtcore_vulkan.h that may grow (core/struct_size.h). The member is the last one of the struct's first
 * version. This library compiles core/struct_size.cpp, which libembree3 does not export. */

#include "kernels/cbvh/core/struct_size.h"

#include <embree3/rtcore_vulkan.h>

namespace embree { namespace core {

CBVH_GROWING_STRUCT(RTCVulkanDeviceInfo, hasRayQuery);
CBVH_GROWING_STRUCT(RTCVulkanHandles, hasRayQuery);
CBVH_GROWING_STRUCT(RTCVulkanSceneArguments, previous);
CBVH_GROWING_STRUCT(RTCVulkanSceneStatistics, numUpdatedBoxes);
CBVH_GROWING_STRUCT(RTCVulkanTimes, sortSeconds);

}} // namespace embree::core
