// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory that the commit of a geometry allocates without calling the application's memory monitor
 * (rtcSetDeviceMemoryMonitorFunction), which could refuse it: programs do not expect the commit of a geometry to fail.
 * The build of the blocks reports what is still allocated (ReportedMemory), and fails if the application refuses it. */

#include "../embree/scene.h"

namespace embree::cbvh {
/*! A monitor that refuses nothing. Thread-safe. */
inline MemoryMonitorInterface* silentMonitor() {
  struct None : public MemoryMonitorInterface {
    void memoryMonitor(ssize_t, bool) override {}
  };
  static None none;
  return &none;
}

/*! An Embree vector that does not report its memory. */
template<typename T>
struct UnmonitoredVector : public mvector<T> {
  UnmonitoredVector() : mvector<T>(silentMonitor(), 0) {}
};

/*! The constructor reports memory to a device's monitor, the destructor its release. The constructor throws
 *  RTC_ERROR_OUT_OF_MEMORY if the application refuses. No release is reported then, so the constructor passes
 *  post = false (not yet allocated): the application must not count refused memory. */
class ReportedMemory {
public:
  ReportedMemory(Device* device, size_t bytes) : device(device), bytes(ssize_t(bytes)) {
    device->memoryMonitor(this->bytes, false);
  }
  ~ReportedMemory() { device->memoryMonitor(-bytes, true); }
  ReportedMemory(const ReportedMemory&) = delete;
  ReportedMemory& operator=(const ReportedMemory&) = delete;

private:
  Device* const device;
  const ssize_t bytes;
};
} // namespace embree::cbvh
