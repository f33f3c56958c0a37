// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "context.h"

#include "cbvh/operations/device.h"
#include "cbvh/operations/device_string.h"

#include <embree3/rtcore_compression.h>

#include <cstdio>
#include <utility>

using namespace embree::capi;

namespace {

thread_local std::string errorText; // text of cbvhGetErrorText

CbvhError codeOf(RTCError code) {
  switch (code) {
  case RTC_ERROR_NONE: return CBVH_OK;
  case RTC_ERROR_INVALID_ARGUMENT: return CBVH_ERROR_INVALID_ARGUMENT;
  case RTC_ERROR_INVALID_OPERATION: return CBVH_ERROR_INVALID_OPERATION;
  case RTC_ERROR_OUT_OF_MEMORY: return CBVH_ERROR_OUT_OF_MEMORY;
  case RTC_ERROR_UNSUPPORTED_CPU: return CBVH_ERROR_UNSUPPORTED_CPU;
  case RTC_ERROR_CANCELLED: return CBVH_ERROR_CANCELLED;
  default: return CBVH_ERROR_UNKNOWN;
  }
}

RTCError codeOf(CbvhError code) {
  switch (code) {
  case CBVH_OK: return RTC_ERROR_NONE;
  case CBVH_ERROR_INVALID_ARGUMENT: return RTC_ERROR_INVALID_ARGUMENT;
  case CBVH_ERROR_INVALID_OPERATION: return RTC_ERROR_INVALID_OPERATION;
  case CBVH_ERROR_OUT_OF_MEMORY: return RTC_ERROR_OUT_OF_MEMORY;
  case CBVH_ERROR_UNSUPPORTED_CPU: return RTC_ERROR_UNSUPPORTED_CPU;
  case CBVH_ERROR_CANCELLED: return RTC_ERROR_CANCELLED;
  default: return RTC_ERROR_UNKNOWN;
  }
}

/* Error function of a context's own device, for errors that no ErrorScope collects, such as those of rays. */
void handleEmbreeError(void* context, RTCError code, const char* text) {
  Failure failure = {codeOf(code), ""};
  try {
    if (text) failure.text = text;
  } catch (const std::bad_alloc&) {} // without the text: exceptions must not leave functions of C
  ((const CbvhContextTy*)context)->report(failure);
}

/* Returns and clears the error that the current ErrorScope collected last. */
Failure takeCollected() {
  embree::core::ErrorCollector* const collector = embree::core::currentCollector();
  if (!collector) return {CBVH_OK, ""};
  const CbvhError code = codeOf(std::exchange(collector->last.code, RTC_ERROR_NONE));
  return {code, std::exchange(collector->last.text, {})};
}

/* Must be called in a catch block. */
Failure exceptionAsFailure() {
  try {
    throw;
  } catch (Failure& failure) { return std::move(failure); } catch (...) {
    embree::core::CaughtError error = embree::core::caughtError();
    return {codeOf(error.code), std::move(error.text)};
  }
}

RTCDevice newDevice(const char* settings) {
  try {
    return (RTCDevice)embree::core::newDevice(settings);
  } catch (...) {
    const Failure failure = exceptionAsFailure();
    throw Failure{failure.code, std::string("cannot create a context with ") +
                                    (settings ? std::string("the settings '") + settings + "'" : "default settings") +
                                    ": " + failure.text};
  }
}

} // namespace

const char RefCounted::thisLibrary = 0;

CbvhContextTy::CbvhContextTy(const char* settings, CbvhErrorFunction function, void* userPtr)
  : device(newDevice(settings)),
    ownsDevice(true),
    function(function),
    userPtr(userPtr) {
  rtcSetDeviceErrorFunction(device, handleEmbreeError, this);
}

CbvhContextTy::CbvhContextTy(RTCDevice device)
  : device(device),
    ownsDevice(false),
    function(nullptr),
    userPtr(nullptr) {
  rtcRetainDevice(device);
}

CbvhContextTy::~CbvhContextTy() {
  if (ownsDevice) rtcSetDeviceErrorFunction(device, nullptr, nullptr);
  rtcReleaseDevice(device);
}

Failure CbvhContextTy::takeError() const { return takeCollected(); }

void CbvhContextTy::check() const {
  const Failure failure = takeError();
  if (failure) throw failure;
}

CbvhError CbvhContextTy::report(const Failure& failure) const {
  const ErrorScope none;
  if (!ownsDevice) raise(device, failure);
  return callErrorFunction(failure, function, userPtr);
}

void embree::capi::raise(RTCDevice device, const Failure& failure) {
  embree::core::raiseError((embree::Device*)device, codeOf(failure.code), failure.text.c_str());
}

Failure embree::capi::caughtFailure() {
  Failure failure = exceptionAsFailure();
  const Failure collected = takeCollected();
  try {
    if (collected && collected.text != failure.text) failure.text += ": " + collected.text;
  } catch (const std::bad_alloc&) {} // without the reason
  return failure;
}

ErrorScope::ErrorScope(const CbvhContextTy* context)
  : outer(std::exchange(embree::core::currentCollector(), &collector)) {
  if (context) collector.device = context->device;
}

ErrorScope::~ErrorScope() { embree::core::currentCollector() = outer; }

/* Keeps no text if there is no memory for it: exceptions must not leave functions of C. */
static void setErrorText(const char* text) {
  try {
    errorText = text;
  } catch (const std::bad_alloc&) { errorText.clear(); }
}

CbvhError embree::capi::callErrorFunction(const Failure& failure, CbvhErrorFunction function, void* userPtr) {
  setErrorText(failure.text.c_str());
  if (!function) return failure.code;
  function(userPtr, failure.code, failure.text.c_str());
  setErrorText(failure.text.c_str()); // an error that the function caused must not replace this one
  return failure.code;
}

void embree::capi::checkFlags(unsigned int flags, unsigned int known, const char* of) {
  const unsigned int unknown = flags & ~known;
  if (!unknown) return;
  char text[96];
  std::snprintf(text, sizeof(text), "unknown flags 0x%x of a %s: expected bits of 0x%x", unknown, of, known);
  throw Failure{CBVH_ERROR_INVALID_ARGUMENT, text};
}

CbvhError embree::capi::rejectArgument(const char* text) {
  setErrorText(text);
  return CBVH_ERROR_INVALID_ARGUMENT;
}

const char* cbvhGetErrorText() { return errorText.c_str(); }
unsigned int cbvhGetVersion() { return RTC_COMPRESSION_VERSION; }

CbvhError cbvhNewContext(const char* settings, CbvhErrorFunction function, void* userPtr, CbvhContext* context) {
  if (!context) return rejectArgument("context is NULL");
  Failure failure;
  try {
    const std::string wrong = embree::findDeviceStringError(settings);
    if (!wrong.empty())
      throw Failure{CBVH_ERROR_INVALID_ARGUMENT, std::string("settings '") + settings + "': " + wrong};
    *context = new CbvhContextTy(settings, function, userPtr);
    return CBVH_OK;
  } catch (...) { failure = caughtFailure(); }
  return callErrorFunction(failure, function, userPtr);
}

void cbvhRetainContext(CbvhContext context) {
  if (context) context->retain();
}
void cbvhReleaseContext(CbvhContext context) {
  if (context) context->release();
}
