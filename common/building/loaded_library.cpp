// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/loaded_library.h"
#include "basics/error.h"

#include <embree3/rtcore.h>
#include <embree3/rtcore_compression.h>

#include <dlfcn.h>

namespace programs {
namespace {

/* A wheel's library has another file name, and its functions have other names, see scripts/packaging/wheel.cmake. */
#ifdef CBVH_WHEEL
constexpr const char* namePrefix = "__wrap_";

void* openLibrary() {
  Dl_info info;
  const bool isKnown = dladdr(reinterpret_cast<void*>(&rtcNewDevice), &info);
  return isKnown ? dlopen(info.dli_fname, RTLD_LAZY | RTLD_NOLOAD) : nullptr;
}
#else
constexpr const char* namePrefix = "";

void* openLibrary() { return dlopen("libembree3.so.3", RTLD_LAZY | RTLD_NOLOAD); }
#endif

/* dlsym is necessary: cbvh_bench defines functions of these names, and stock Embree lacks some of them. */
void* functionOf(void* library, const std::string& name) { return dlsym(library, (namePrefix + name).c_str()); }

std::string versionText(ssize_t number) // for example 31305
{
  return std::to_string(number / 10000) + "." + std::to_string(number / 100 % 100) + "." + std::to_string(number % 100);
}

} // namespace

std::string LoadedLibrary::description() const {
  return (cbvhVersion.empty() ? "" : "Embree CBVH " + cbvhVersion + " on ") + "Embree" +
         (embreeVersion.empty() ? "" : " " + embreeVersion) + (cbvhVersion.empty() ? ", without compression, " : ", ") +
         path;
}

LoadedLibrary loadedLibrary() {
  LoadedLibrary library;
  void* const opened = openLibrary();
  if (!opened) return library;

  const auto newDevice = reinterpret_cast<decltype(&rtcNewDevice)>(functionOf(opened, "rtcNewDevice"));
  const auto releaseDevice = reinterpret_cast<decltype(&rtcReleaseDevice)>(functionOf(opened, "rtcReleaseDevice"));
  const auto property = reinterpret_cast<decltype(&rtcGetDeviceProperty)>(functionOf(opened, "rtcGetDeviceProperty"));
  const auto ourProperty = reinterpret_cast<decltype(&rtcGetDeviceCompressionProperty)>(
      functionOf(opened, "rtcGetDeviceCompressionProperty"));
  Dl_info info;
  if (dladdr(reinterpret_cast<void*>(newDevice), &info)) library.path = info.dli_fname;
  if (RTCDevice device = newDevice("threads=1")) {
    library.embreeVersion = versionText(property(device, RTC_DEVICE_PROPERTY_VERSION));
    if (ourProperty) library.cbvhVersion = versionText(ourProperty(device, RTC_COMPRESSION_PROPERTY_VERSION));
    releaseDevice(device);
  }
  dlclose(opened);
  return library;
}

void requireCompression() {
  if (functionOf(RTLD_DEFAULT, "rtcSetGeometryCompression")) return;
  throw Error("the loaded library cannot compress: it is " + loadedLibrary().description() +
              "; expected the folder of Embree CBVH's libembree3.so.3 first in LD_LIBRARY_PATH");
}

} // namespace programs
