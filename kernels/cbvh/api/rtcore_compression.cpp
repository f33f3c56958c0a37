// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#define RTC_EXPORT_API

#include "../embree/scene.h"
#include "../base/kinds.h"
#include "factory.h"
#include "loaded_geometry.h"
#include "../../../include/embree3/rtcore_compression.h"
#include <cmath>
#include <cstring>

using namespace embree;

RTC_NAMESPACE_BEGIN;

RTC_API ssize_t rtcGetDeviceCompressionProperty (RTCDevice hdevice, enum RTCCompressionProperty prop)
{
  Device* device = (Device*) hdevice;
  RTC_CATCH_BEGIN;
  if (hdevice == nullptr)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"device is NULL");
  int property; // an enumeration may not hold what the application may have passed
  memcpy(&property,&prop,sizeof(property));
  switch (property)
  {
  case RTC_COMPRESSION_PROPERTY_VERSION:       return RTC_COMPRESSION_VERSION;
  case RTC_COMPRESSION_PROPERTY_VERSION_MAJOR: return RTC_COMPRESSION_VERSION_MAJOR;
  case RTC_COMPRESSION_PROPERTY_VERSION_MINOR: return RTC_COMPRESSION_VERSION_MINOR;
  case RTC_COMPRESSION_PROPERTY_VERSION_PATCH: return RTC_COMPRESSION_VERSION_PATCH;
  }
  throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"unknown property of compression " + std::to_string(property));
  RTC_CATCH_END(device);
  return 0;
}

RTC_API void rtcSetGeometryCompression (RTCGeometry hgeometry, const struct RTCCompressionArguments* args)
{
  Geometry* geometry = (Geometry*) hgeometry;
  RTC_CATCH_BEGIN;
  if (hgeometry == nullptr)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"geometry is NULL");
  if (args == nullptr)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"args is NULL");
  CompressibleGeometry* const compressible = embree::compressible(geometry);
  if (!compressible)
    throw_RTCError(RTC_ERROR_INVALID_OPERATION,"only geometry of type RTC_GEOMETRY_TYPE_SUBDIVISION, RTC_GEOMETRY_TYPE_GRID, RTC_GEOMETRY_TYPE_QUAD or RTC_GEOMETRY_TYPE_TRIANGLE can be compressed");
  if (dynamic_cast<LoadedGeometry*>(geometry))
    throw_RTCError(RTC_ERROR_INVALID_OPERATION,LoadedGeometry::whyNot);
  int compression; // an enumeration may not hold what the application may have written
  memcpy(&compression,&args->compression,sizeof(compression));
  cbvh::Kind kind;
  if (compression != RTC_COMPRESSION_INHERIT && compression != RTC_COMPRESSION_NONE && !cbvh::findKind(compression,kind))
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,(compression >= RTC_COMPRESSION_GRID && compression <= RTC_COMPRESSION_LEAF ? "this library was built without compression " : "unknown compression ") + std::to_string(compression));
  if (args->frameLevel < RTC_COMPRESSION_FRAME_LEVEL_INHERIT || args->frameLevel > int(cbvh::maxLevel))
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"invalid frameLevel " + std::to_string(args->frameLevel) + ": expected 0 to " + std::to_string(cbvh::maxLevel) + ", AUTO or INHERIT");
  if (!std::isfinite(args->maxError))
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"invalid maxError " + std::to_string(args->maxError) + ": expected a distance, or a negative number to inherit");
  if (!std::isfinite(args->maxPixelError) || args->maxPixelError < 0.0f)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"invalid maxPixelError " + std::to_string(args->maxPixelError) + ": expected a number of pixels, or 0 for no bound");
  if (args->maxPixelError > 0.0f) {
    if (!std::isfinite(args->pixelSize) || args->pixelSize <= 0.0f)
      throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"invalid pixelSize " + std::to_string(args->pixelSize) + ": expected the width of a pixel at distance 1");
    for (float x : args->cameraPosition)
      if (!std::isfinite(x)) throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"invalid cameraPosition " + std::to_string(x) + ": expected a position in the world");
  }

  if (args->exactFaces > 1)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"invalid exactFaces " + std::to_string(args->exactFaces) + ": expected 0, 1, or a negative number to inherit");

  if (args->flags & ~unsigned(RTC_COMPRESSION_FLAG_RELEASE_INPUT))
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"unknown flags " + std::to_string(args->flags));

  CompressionSettings& settings = compressible->compression;
  settings.compression = args->compression;
  settings.frameLevel = args->frameLevel;
  settings.maxError = args->maxError;
  settings.maxPixelError = args->maxPixelError;
  memcpy(settings.cameraPosition,args->cameraPosition,sizeof(settings.cameraPosition));
  settings.pixelSize = args->pixelSize;
  settings.exactFaces = args->exactFaces;
  settings.releasesInput = (args->flags & RTC_COMPRESSION_FLAG_RELEASE_INPUT) != 0;
  settings.progress = args->progress;
  settings.progressUserPtr = args->progressUserPtr;
  geometry->Geometry::update();
  RTC_CATCH_END2(geometry);
}

RTC_API void rtcGetSceneCompressionStatistics (RTCScene hscene, struct RTCCompressionStatistics* stats)
{
  Scene* scene = (Scene*) hscene;
  RTC_CATCH_BEGIN;
  if (hscene == nullptr)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"scene is NULL");
  if (stats == nullptr)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"stats is NULL");
  bool modified = scene->isModified();
  for (size_t i=0; i<scene->size(); i++)
    modified |= scene->get(i) && scene->get(i)->isEnabled() && scene->isGeometryModified(i);
  if (modified)
    throw_RTCError(RTC_ERROR_INVALID_OPERATION,"scene not committed");

  *stats = RTCCompressionStatistics();
  for (Accel* accel : scene->accels)
    if (const CompressedAccel* compressed = dynamic_cast<CompressedAccel*>(accel))
      cbvh::add(*stats,compressed->report->statistics);
  RTC_CATCH_END2(scene);
}

RTC_NAMESPACE_END
