// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Functions of this folder throw Embree's rtcore_error or std::bad_alloc. rtc functions catch them with RTC_CATCH_END,
 * interfaces without Embree's internal headers with caughtError(). libembree3_vulkan compiles only struct_size.cpp of
 * this folder; there it throws VulkanError. */

#include "../../../include/embree3/rtcore.h"
#include <string>

namespace embree::core {
struct CaughtError {
  RTCError code; //!< never RTC_ERROR_NONE
  std::string text;
};

/*! Returns the exception that the enclosing catch block handles. Exceptions other than rtcore_error and
 *  std::bad_alloc become RTC_ERROR_UNKNOWN. If there is no memory for its text, any exception becomes
 *  RTC_ERROR_OUT_OF_MEMORY. Outside of a catch block it ends the process. */
CaughtError caughtError() noexcept;

/*! Keeps the errors that Embree reports on a thread. */
struct ErrorCollector {
  const void* device = nullptr;            //!< collects errors of this device; null: of none
  CaughtError last = {RTC_ERROR_NONE, {}}; //!< the last error
};

/*! The current collector of this thread, or null. */
ErrorCollector*& currentCollector() noexcept;

/*! Stores an error in this thread's collector if it collects errors of the device. Otherwise returns false. Called by
 *  Device::process_error, which then handles the error. text: may be null. */
bool collectError(const void* device, RTCError code, const char* text) noexcept;

/*! Throws RTC_ERROR_INVALID_ARGUMENT. For code without Embree's internal headers. libembree3_vulkan has its own
 *  definition, in rtcore_vulkan.cpp. */
[[noreturn]] void throwInvalidArgument(const std::string& text);
} // namespace embree::core
