// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/embree_device.h"
#include "building/loaded_library.h"
#include "basics/error.h"
#include "basics/progress.h"

namespace programs {

void MemoryMonitor::count(ssize_t bytes) {
  const ssize_t now = liveBytes.fetch_add(bytes) + bytes;
  ssize_t seen = peakBytes.load();
  while (now > seen && !peakBytes.compare_exchange_weak(seen, now));
}

const char* errorName(RTCError code) {
  switch (code) {
  case RTC_ERROR_NONE: return "no error";
  case RTC_ERROR_INVALID_ARGUMENT: return "invalid argument";
  case RTC_ERROR_INVALID_OPERATION: return "invalid operation";
  case RTC_ERROR_OUT_OF_MEMORY: return "out of memory";
  case RTC_ERROR_UNSUPPORTED_CPU: return "unsupported CPU";
  case RTC_ERROR_CANCELLED: return "canceled";
  default: return "unknown error";
  }
}

EmbreeDevice::EmbreeDevice(const std::string& config) {
  /* Embree accepts any name here and rejects it only when a scene is committed. */
  if (config.find("subdiv_accel=cbvh") != std::string::npos) requireCompression();
  device = rtcNewDevice(config.c_str());
  if (!device)
    throw Error("Embree rejects the configuration \"" + config + "\": " + errorName(rtcGetDeviceError(nullptr)));
  rtcSetDeviceErrorFunction(device, onError, this);
  rtcSetDeviceMemoryMonitorFunction(device, onMemory, this);
}

EmbreeDevice::~EmbreeDevice() { rtcReleaseDevice(device); }

void EmbreeDevice::check(const char* operation) {
  std::lock_guard<std::mutex> lock(mutex);
  if (errorCode == RTC_ERROR_NONE) return;
  const RTCError code = errorCode;
  errorCode = RTC_ERROR_NONE;
  /* A displacement function throws Canceled; Embree reports that as an unknown error. */
  if (code == RTC_ERROR_CANCELLED || cancelRequested()) throw Canceled();
  throw Error(std::string("Embree, ") + operation + ": " + errorName(code) +
              (errorMessage.empty() ? "" : ": " + errorMessage));
}

void EmbreeDevice::onError(void* self, RTCError code, const char* message) {
  EmbreeDevice& device = *static_cast<EmbreeDevice*>(self);
  std::lock_guard<std::mutex> lock(device.mutex);
  if (device.errorCode != RTC_ERROR_NONE) return; // later errors are consequences
  device.errorCode = code;
  device.errorMessage = message ? message : "";
}

bool EmbreeDevice::onMemory(void* self, ssize_t bytes, bool) {
  static_cast<EmbreeDevice*>(self)->monitor.count(bytes);
  return true;
}

} // namespace programs
