// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compression settings of a device or a geometry. A geometry inherits unset members from the device string, then from
 * the environment, then from the defaults. */

#include "../../../include/embree3/rtcore_compression.h"
#include <memory>
#include <string>

namespace embree {
class Token;
class TokenStream;
namespace cbvh {
class MemoryBudget;
}

struct CompressionSettings {
  RTCCompression compression = RTC_COMPRESSION_INHERIT;
  int frameLevel = RTC_COMPRESSION_FRAME_LEVEL_INHERIT;
  float maxError = -1.0f; //!< world units; 0: lossless cVERT; negative: inherited, or the default
  float maxPixelError = 0.0f, cameraPosition[3] = {0.0f, 0.0f, 0.0f}, pixelSize = 0.0f; //!< set for geometries only
  int fallbackFaces = -1;         //!< 1: faces that cLEAF represents badly, and moving cages, become cVERT; negative:
                                  //!< inherited
  bool releasesInput = false;     //!< if set for a device, holds for all its geometries
  bool storesSmallMeshes = false; //!< set for geometries only: not just meshes of many primitives
  bool warnsOfFaces = true;       //!< set for geometries only: whether commits print which faces are left out
  /*! Set for devices only: types of geometry that inherit the device's compression. */
  bool compressesGrids = true, compressesQuads = true, compressesTriangles = true;
  std::shared_ptr<cbvh::MemoryBudget> memory;    //!< set for devices only; null: no limit
  RTCProgressMonitorFunction progress = nullptr; //!< set for geometries only
  void* progressUserPtr = nullptr;

  /*! Parses keys with the prefix cbvh_ in a device string. Returns false for Embree's keys and for tokens that are
   *  not keys. Throws rtcore_error for invalid values and for unknown keys that begin with "cbvh". Keeps other
   *  unknown keys for finishParsing(). */
  bool parse(const Token& key, TokenStream& stream);

  /*! Selected by EMBREE_CBVH=1 and subdiv_accel=cbvh, and the form of libembree_cbvh's surfaces. cTILE is exact, and
   *  faster than Embree's own forms in a seventh of their memory or less; cVERT takes half of it, but rays decode it
   *  (docs/measurements.md). */
  static const RTCCompression preferredCompression = RTC_COMPRESSION_CTILE;

  /*! Parses EMBREE_CBVH, for example "leaf,frame_level=2". Throws rtcore_error. Call this before parse(), whose
   *  settings take precedence. */
  void parseEnvironment();

  /*! Call this after parse() received the entire device string. Sets `compression` to what subdiv_accel selects;
   *  "default" has no effect. Throws rtcore_error for unknown "cbvh" kinds, and for unknown keys if subdiv_accel, or
   *  the value of the key, requests compression. verbose: prints the version and the compression. */
  void finishParsing(const std::string& subdivAccel, bool verbose);

  /*! Returns the effective settings of a geometry: no member is inherited. */
  CompressionSettings resolve(const CompressionSettings& device) const;

private:
  void setFrameLevel(const std::string& name, const std::string& value);
  void setMaxError(const std::string& name, const std::string& value);
  void setMemory(const std::string& name, const std::string& value);
  void set(const std::string& name, const std::string& key, const std::string& value);
};
} // namespace embree
