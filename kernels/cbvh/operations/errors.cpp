// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "errors.h"
#include "../embree/scene.h"
#include <exception>
#include <new>

namespace embree::core {
CaughtError caughtError() noexcept {
  try {
    try {
      throw;
    } catch (const std::bad_alloc&) { throw; } catch (const rtcore_error& error) {
      return {error.error, error.what()};
    } catch (const std::exception& error) { return {RTC_ERROR_UNKNOWN, error.what()}; } catch (...) {
      return {RTC_ERROR_UNKNOWN, "unknown exception caught"};
    }
  }
  // also if there is no memory for a copy of the text; this text is so short that std::string allocates nothing
  catch (const std::bad_alloc&) {
    return {RTC_ERROR_OUT_OF_MEMORY, "out of memory"};
  }
}

ErrorCollector*& currentCollector() noexcept {
  static thread_local ErrorCollector* current = nullptr;
  return current;
}

bool collectError(const void* device, RTCError code, const char* text) noexcept {
  ErrorCollector* const collector = currentCollector();
  if (!collector || !device || collector->device != device) return false;
  CaughtError& last = collector->last;
  last.code = code;
  try {
    last.text = text ? text : "";
  } catch (const std::bad_alloc&) { last.text.clear(); }
  return true;
}

void throwInvalidArgument(const std::string& text) { throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, text); }
} // namespace embree::core
