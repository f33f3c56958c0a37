// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "errors.h"

namespace embree {
class Device;

namespace core {
/*! As rtcNewDevice, but throws the reason of a failure; rtcNewDevice keeps only its code. Errors:
 *  RTC_ERROR_INVALID_ARGUMENT for invalid settings of compression, in the device string or in EMBREE_CBVH;
 *  RTC_ERROR_UNSUPPORTED_CPU. deviceString: may be null. The reference count is 1. Thread safety: any thread may
 *  call it at any time. */
Device* newDevice(const char* deviceString);
} // namespace core
} // namespace embree
