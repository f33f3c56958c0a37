// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Functions of host/ throw VulkanError, which rtcore_vulkan.cpp passes to the RTCDevice. */

#include <embree3/rtcore.h>

#include <stdexcept>
#include <string>

namespace embree::vulkan {

/* code: RTC_ERROR_NONE if the RTCDevice already received the error. */
class VulkanError : public std::runtime_error {
public:
  VulkanError(RTCError code, const std::string& message) : std::runtime_error(message), code(code) {}
  const RTCError code;
};

} // namespace embree::vulkan
