// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory that a geometry commit allocates. It is not reported to the application's monitor, because programs do not
 * expect this commit to fail: if the application refused memory and detached the geometry before the next scene commit,
 * it would get no error. The scene commit reports this memory and may fail. */

#include "../embree/scene.h"

namespace embree
{
  namespace cbvh
  {
    /*! A monitor that ignores reports and refuses nothing. Thread-safe. */
    inline MemoryMonitorInterface* silentMonitor ()
    {
      struct None : public MemoryMonitorInterface
      {
        void memoryMonitor (ssize_t, bool) override {}
      };
      static None none;
      return &none;
    }

    template<typename T>
    struct UnmonitoredVector : public mvector<T>
    {
      UnmonitoredVector () : mvector<T>(silentMonitor(),0) {}
    };

    /*! Reports memory to a device's monitor while this object exists. The constructor throws RTC_ERROR_OUT_OF_MEMORY if
     *  the application refuses. The memory is reported as not yet allocated, because an application counts allocated
     *  memory that it refuses until the release is reported. */
    class ReportedMemory
    {
    public:
      ReportedMemory (Device* device, size_t bytes) : device(device), bytes(ssize_t(bytes)) {
        device->memoryMonitor(this->bytes,false);
      }
      ~ReportedMemory () { device->memoryMonitor(-bytes,true); }
      ReportedMemory (const ReportedMemory&) = delete;
      ReportedMemory& operator= (const ReportedMemory&) = delete;

    private:
      Device* const device;
      const ssize_t bytes;
    };
  }
}
