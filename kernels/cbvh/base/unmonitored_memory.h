// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory that the commit of a geometry allocates. Programs do not expect this commit to fail, and an application that
 * refuses memory to it would get no error if it detached the geometry before the next commit of the scene. So this
 * memory is not reported to the application's monitor while it is allocated. The commit of a scene reports the size of
 * what exists until then, and may fail. */

#include "../embree/scene.h"

namespace embree
{
  namespace cbvh
  {
    /*! Returns a monitor that refuses nothing and reports nothing. Thread-safe. */
    inline MemoryMonitorInterface* unmonitoredMemory ()
    {
      struct None : public MemoryMonitorInterface
      {
        void memoryMonitor (ssize_t, bool) override {}
      };
      static None none;
      return &none;
    }

    /*! Embree's vector without reports. */
    template<typename T>
    struct UnmonitoredVector : public mvector<T>
    {
      UnmonitoredVector () : mvector<T>(unmonitoredMemory(),0) {}
    };

    /*! Reports memory that exists to the monitor of a device, for the lifetime of this object. The constructor throws
     *  RTC_ERROR_OUT_OF_MEMORY if the application refuses. */
    class ReportedMemory
    {
    public:
      ReportedMemory (Device* device, size_t bytes) : device(device), bytes(ssize_t(bytes)) {
        device->memoryMonitor(this->bytes,true);
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
