// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* An Embree device that throws exceptions and counts memory. Each representation has a device of its own, so that its
 * memory is counted alone. */

#include <embree3/rtcore.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>

namespace programs {

class MemoryMonitor {
public:
  size_t live() const { return size_t(liveBytes.load()); }
  size_t peak() const { return size_t(peakBytes.load()); }

  void resetPeak() { peakBytes.store(liveBytes.load()); }

  void count(ssize_t bytes);

private:
  std::atomic<ssize_t> liveBytes{0}, peakBytes{0};
};

class EmbreeDevice {
public:
  /* `config` is Embree's configuration string. Throws Error if Embree rejects it, or if it selects
   * compression and the library has none. */
  explicit EmbreeDevice(const std::string& config);
  ~EmbreeDevice();
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  RTCDevice handle() const { return device; }
  MemoryMonitor& memory() { return monitor; }

  /* Throws Error if an error occurred since the last call, or Canceled if the build was canceled. `operation` names the
   * operation in the message. Thread-safe. */
  void check(const char* operation);

private:
  static void onError(void* self, RTCError code, const char* message);
  static bool onMemory(void* self, ssize_t bytes, bool post);

  MemoryMonitor monitor;
  RTCDevice device = nullptr;
  std::mutex mutex;
  RTCError errorCode = RTC_ERROR_NONE;
  std::string errorMessage;
};

const char* errorName(RTCError code);

struct SceneRelease {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct GeometryRelease {
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using SceneHandle = std::unique_ptr<RTCSceneTy, SceneRelease>;
using GeometryHandle = std::unique_ptr<RTCGeometryTy, GeometryRelease>;

/* The geometry owns the buffer (slot 0). `operation` names the operation in errors. Throws Error. */
template<typename T>
T* newBuffer(EmbreeDevice& device, RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t count,
             const char* operation) {
  void* data = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count);
  device.check(operation);
  return static_cast<T*>(data);
}

} // namespace programs
