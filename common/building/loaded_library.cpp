// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/loaded_library.h"
#include "basics/error.h"

#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <dlfcn.h>

namespace cbvh {
namespace {

std::string versionText(ssize_t number) // for example 31305
{
  return std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." + std::to_string(number % 100);
}

} // namespace

std::string LoadedLibrary::description() const
{
  return (ours.empty() ? "" : "Embree CBVH " + ours + " on ") + "Embree" + (release.empty() ? "" : " " + release) +
         (ours.empty() ? ", without compression, " : ", ") + path;
}

LoadedLibrary loadedLibrary()
{
  LoadedLibrary library;
  void* const opened = dlopen("libembree3.so.3", RTLD_LAZY | RTLD_NOLOAD);
  if (!opened)
    return library;

  /* dlsym is necessary: cbvh_bench defines functions of these names, and stock Embree lacks some of them. */
  const auto newDevice = reinterpret_cast<decltype(&rtcNewDevice)>(dlsym(opened, "rtcNewDevice"));
  const auto releaseDevice = reinterpret_cast<decltype(&rtcReleaseDevice)>(dlsym(opened, "rtcReleaseDevice"));
  const auto property = reinterpret_cast<decltype(&rtcGetDeviceProperty)>(dlsym(opened, "rtcGetDeviceProperty"));
  const auto ourProperty =
    reinterpret_cast<decltype(&rtcGetDeviceCompressionProperty)>(dlsym(opened, "rtcGetDeviceCompressionProperty"));
  Dl_info info;
  if (dladdr(reinterpret_cast<void*>(newDevice), &info))
    library.path = info.dli_fname;
  if (RTCDevice device = newDevice("threads=1"))
  {
    library.release = versionText(property(device, RTC_DEVICE_PROPERTY_VERSION));
    if (ourProperty)
      library.ours = versionText(ourProperty(device, RTC_COMPRESSION_PROPERTY_VERSION));
    releaseDevice(device);
  }
  dlclose(opened);
  return library;
}

void requireCompression()
{
  if (dlsym(RTLD_DEFAULT, "rtcSetGeometryCompression"))
    return;
  throw Error("the loaded library cannot compress: it is " + loadedLibrary().description() +
              "; expected the folder of Embree CBVH's libembree3.so.3 first in LD_LIBRARY_PATH");
}

} // namespace cbvh
