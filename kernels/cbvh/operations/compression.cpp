// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "compression.h"
#include "../base/kinds.h"
#include "../base/number_text.h"
#include "../files/loaded_geometry.h"
#include "../blocks/report.h"
#include <algorithm>
#include <cmath>
#include <cstring>

namespace embree::core {
namespace {
void validateCompression(const RTCCompression& value) {
  int compression; // memcpy, because a value outside of the enumeration would be undefined behavior
  std::memcpy(&compression, &value, sizeof(compression));
  cbvh::Kind kind;
  if (compression == RTC_COMPRESSION_INHERIT || compression == RTC_COMPRESSION_NONE ||
      cbvh::findKind(compression, kind))
    return;
  const bool isOfPaper = compression >= RTC_COMPRESSION_CGRID && compression <= RTC_COMPRESSION_CLEAF;
  throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                 "invalid compression " + std::to_string(compression) +
                     (isOfPaper ? ": this library was built without it" : ": expected a value of RTCCompression"));
}

std::string textOf(int value) { return std::to_string(value); }
std::string textOf(float value) { return numberText(value); }

template<typename T>
void require(bool isValid, const char* name, T value, const std::string& expected) {
  if (!isValid)
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,
                   std::string("invalid ") + name + " " + textOf(value) + ": expected " + expected);
}
} // namespace

void validate(const CompressionSettings& settings) {
  validateCompression(settings.compression);
  const int maxFrameLevel = int(cbvh::maxFramedLevel);
  require(settings.frameLevel >= RTC_COMPRESSION_FRAME_LEVEL_INHERIT && settings.frameLevel <= maxFrameLevel,
          "frameLevel", settings.frameLevel, "0 to " + std::to_string(maxFrameLevel) + ", AUTO or INHERIT");
  require(std::isfinite(settings.maxError), "maxError", settings.maxError,
          "a distance, or a negative number to inherit");
  require(std::isfinite(settings.maxPixelError) && settings.maxPixelError >= 0.0f, "maxPixelError",
          settings.maxPixelError, "a number of pixels, or 0 for no bound");
  if (settings.maxPixelError > 0.0f) {
    require(std::isfinite(settings.pixelSize) && settings.pixelSize > 0.0f, "pixelSize", settings.pixelSize,
            "the width of a pixel at distance 1");
    for (float x : settings.cameraPosition) require(std::isfinite(x), "cameraPosition", x, "a position in the world");
  }
  require(settings.fallbackFaces <= 1, "fallbackFaces", settings.fallbackFaces,
          "0, 1, or a negative number to inherit");
}

bool selectSameBlocks(const CompressionSettings& a, const CompressionSettings& b) {
  const float(&from)[3] = a.cameraPosition, (&other)[3] = b.cameraPosition;
  const bool haveSameCamera = a.pixelSize == b.pixelSize && std::equal(from, from + 3, other);
  return a.compression == b.compression && a.frameLevel == b.frameLevel && a.maxError == b.maxError &&
         a.maxPixelError == b.maxPixelError && (a.maxPixelError == 0.0f || haveSameCamera) &&
         a.fallbackFaces == b.fallbackFaces && a.storesSmallMeshes == b.storesSmallMeshes;
}

RTCCompression exactCompression(const Device* device) {
  const RTCCompression selected = device->compression.compression;
  return cbvh::isExact(selected) ? selected : CompressionSettings::preferredCompression;
}

void setCompression(Geometry* geometry, const CompressionSettings& settings) {
  CompressibleGeometry* const compressible = asCompressible(geometry);
  if (!compressible)
    throw_RTCError(
        RTC_ERROR_INVALID_OPERATION,
        "only geometry of type RTC_GEOMETRY_TYPE_SUBDIVISION, RTC_GEOMETRY_TYPE_GRID, RTC_GEOMETRY_TYPE_QUAD or "
        "RTC_GEOMETRY_TYPE_TRIANGLE can be compressed");
  requireEditable(geometry);
  validate(settings);
  const bool isSame = selectSameBlocks(settings, compressible->compression) &&
                      settings.releasesInput == compressible->compression.releasesInput;
  compressible->compression = settings;
  if (!isSame) geometry->Geometry::update();
}

bool hasBlocks(Geometry* geometry) {
  const CompressibleGeometry* const compressible = asCompressible(geometry);
  return compressible && compressible->surface.blocks;
}

size_t numUnsupportedFaces(Geometry* geometry) {
  const CompressibleGeometry* const compressible = asCompressible(geometry);
  return compressible && compressible->surface.blocks
             ? compressible->surface.blocks->statistics.sums.numUnsupportedFaces
             : 0;
}

const char* reasonNotCompressed(Geometry* geometry) {
  const CompressibleGeometry* const compressible = asCompressible(geometry);
  return compressible && compressible->surface.rejectionReason && *compressible->surface.rejectionReason
             ? compressible->surface.rejectionReason
             : nullptr;
}

cbvh::CompressionStatistics statisticsOf(Scene* scene) {
  bool modified = scene->isModified();
  for (size_t i = 0; i < scene->size(); i++)
    modified |= scene->get(i) && scene->get(i)->isEnabled() && scene->isGeometryModified(i);
  if (modified) throw_RTCError(RTC_ERROR_INVALID_OPERATION, "scene not committed");
  cbvh::CompressionStatistics statistics;
  for (Accel* accel : scene->accels)
    if (const CompressedAccel* compressed = dynamic_cast<CompressedAccel*>(accel))
      cbvh::add(statistics, compressed->report->statistics);
  return statistics;
}
} // namespace embree::core
