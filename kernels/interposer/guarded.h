// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Functions that override Embree's are called from C, so no exception may leave them. */

#include "options.h"

#include <exception>

namespace interposer {

/* Calls a closure that can run out of memory. Returns false, and prints a warning, if it does: Embree 4 has no function
 * by which another library could report RTC_ERROR_OUT_OF_MEMORY. function: name, for the warning. */
template<typename Closure>
bool guarded(const char* function, const Closure& closure) {
  try {
    closure();
    return true;
  } catch (const std::exception&) { // std::bad_alloc, or std::length_error of a container
    warnOnce("%s: out of memory", function);
    return false;
  }
}

} // namespace interposer
