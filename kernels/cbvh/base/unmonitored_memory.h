// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory that the commit of a geometry allocates. Programs do not expect this commit to fail: if an application refused
 * memory and detached the geometry before the next commit of the scene, it would get no error. This memory is therefore
 * not reported to the application's monitor. The commit of a scene reports the memory that exists then, and may
 * fail. */

#include "../embree/scene.h"

namespace embree
{
  namespace cbvh
  {
    /*! Returns a monitor that refuses nothing and reports nothing. Thread-safe. */
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

    /*! Reports memory to the monitor of a device while this object exists. The constructor throws
     *  RTC_ERROR_OUT_OF_MEMORY if the application refuses. It reports the memory as not yet allocated, since an
     *  application that refuses allocated memory still counts it until its release is reported. */
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
