// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The C API of include/embree3/rtcore_compression.h: checks pointers and flags, calls operations/compression.h, and
 * reports exceptions to the device. Errors that concern no device, such as NULL objects, are reported to the calling
 * thread. */

#define RTC_EXPORT_API

#include "structs.h"
#include "../operations/compression.h"

using namespace embree;

namespace {
CompressionSettings settingsOf(const RTCCompressionArguments& args) {
  if (args.flags & ~unsigned(RTC_COMPRESSION_FLAG_RELEASE_INPUT | RTC_COMPRESSION_FLAG_SMALL_MESHES))
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                   "invalid flags " + std::to_string(args.flags) +
                       ": expected bits of RTC_COMPRESSION_FLAG_RELEASE_INPUT and RTC_COMPRESSION_FLAG_SMALL_MESHES");
  CompressionSettings settings;
  // memcpy, because a value outside of the enumeration would be undefined behavior
  memcpy(&settings.compression, &args.compression, sizeof(settings.compression));
  settings.frameLevel = args.frameLevel;
  settings.maxError = args.maxError;
  settings.maxPixelError = args.maxPixelError;
  std::copy_n(args.cameraPosition, 3, settings.cameraPosition);
  settings.pixelSize = args.pixelSize;
  settings.fallbackFaces = args.fallbackFaces;
  settings.releasesInput = (args.flags & RTC_COMPRESSION_FLAG_RELEASE_INPUT) != 0;
  settings.storesSmallMeshes = (args.flags & RTC_COMPRESSION_FLAG_SMALL_MESHES) != 0;
  settings.progress = args.progress;
  settings.progressUserPtr = args.progressUserPtr;
  return settings;
}
} // namespace

RTC_NAMESPACE_BEGIN;

RTC_API ssize_t rtcGetDeviceCompressionProperty(RTCDevice hdevice, enum RTCCompressionProperty prop) {
  Device* device = (Device*)hdevice;
  RTC_CATCH_BEGIN;
  requireNotNull(device, "device");
  int property; // memcpy, because a value outside of the enumeration would be undefined behavior
  memcpy(&property, &prop, sizeof(property));
  switch (property) {
  case RTC_COMPRESSION_PROPERTY_VERSION: return RTC_COMPRESSION_VERSION;
  case RTC_COMPRESSION_PROPERTY_VERSION_MAJOR: return RTC_COMPRESSION_VERSION_MAJOR;
  case RTC_COMPRESSION_PROPERTY_VERSION_MINOR: return RTC_COMPRESSION_VERSION_MINOR;
  case RTC_COMPRESSION_PROPERTY_VERSION_PATCH: return RTC_COMPRESSION_VERSION_PATCH;
  }
  throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                 "unknown RTCCompressionProperty " + std::to_string(property) + ": expected 0 to 3");
  RTC_CATCH_END(device);
  return 0;
}

RTC_API void rtcSetGeometryCompression(RTCGeometry hgeometry, const struct RTCCompressionArguments* args) {
  Geometry* geometry = (Geometry*)hgeometry;
  RTC_CATCH_BEGIN;
  requireNotNull(geometry, "geometry");
  requireNotNull(args, "args");
  core::setCompression(geometry, settingsOf(core::readStruct(args)));
  RTC_CATCH_END2(geometry);
}

RTC_API void rtcGetSceneCompressionStatistics(RTCScene hscene, struct RTCCompressionStatistics* statistics) {
  Scene* scene = (Scene*)hscene;
  RTC_CATCH_BEGIN;
  requireNotNull(scene, "scene");
  requireNotNull(statistics, "statistics");
  core::requireStruct(statistics);
  core::writeStruct(statistics, toPublic(core::statisticsOf(scene)));
  RTC_CATCH_END2(scene);
}

RTC_NAMESPACE_END
