// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* An Embree device with its errors as exceptions and its memory counted, and RAII
 * handles for what it makes. One device a representation: the memory monitor then
 * counts that representation and nothing else. */

#include <embree3/rtcore.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <mutex>
#include <string>

namespace cbvh {

/* Bytes a device holds, as rtcSetDeviceMemoryMonitorFunction reports them. */
class MemoryMonitor
{
public:
  size_t live() const { return size_t(liveBytes.load()); }
  size_t peak() const { return size_t(peakBytes.load()); }

  /* Forgets the peak: it starts again at what is live now. */
  void resetPeak() { peakBytes.store(liveBytes.load()); }

  void count(ssize_t bytes);

private:
  std::atomic<ssize_t> liveBytes{0}, peakBytes{0};
};

class EmbreeDevice
{
public:
  /* config: Embree's configuration string. Throws Error when Embree refuses it, or
   * asks for compression where the loaded library is Embree's own. */
  explicit EmbreeDevice(const std::string& config);
  ~EmbreeDevice();
  EmbreeDevice(const EmbreeDevice&) = delete;
  EmbreeDevice& operator=(const EmbreeDevice&) = delete;

  RTCDevice handle() const { return device; }
  MemoryMonitor& memory() { return monitor; }

  /* Throws Error with Embree's message if anything went wrong since the last call,
   * Cancelled if a progress monitor stopped a build. */
  void check(const char* doing);

private:
  static void onError(void* self, RTCError code, const char* message);
  static bool onMemory(void* self, ssize_t bytes, bool post);

  MemoryMonitor monitor; // before the device, which counts until it is gone
  RTCDevice device = nullptr;
  std::mutex mutex;
  RTCError errorCode = RTC_ERROR_NONE;
  std::string errorMessage;
};

/* Name of an Embree error code. */
const char* errorName(RTCError code);

struct SceneRelease
{
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
struct GeometryRelease
{
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
using SceneHandle = std::unique_ptr<RTCSceneTy, SceneRelease>;
using GeometryHandle = std::unique_ptr<RTCGeometryTy, GeometryRelease>;

/* A buffer of a geometry, in slot 0, to be filled. doing: for messages. Throws Error. */
template<typename T>
T* newBuffer(EmbreeDevice& device, RTCGeometry geometry, RTCBufferType type, RTCFormat format, size_t count, const char* doing)
{
  void* data = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(T), count);
  device.check(doing);
  return static_cast<T*>(data);
}

} // namespace cbvh
