// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compression settings of geometries and statistics of scenes, for the C functions in api/ and kernels/capi. Headers
 * of this folder do not include Embree's internal ones. */

#include "../base/surface_statistics.h"
#include "../settings/settings.h"

namespace embree {
class Device;
class Geometry;
class Scene;

namespace core {
/*! Throws RTC_ERROR_INVALID_ARGUMENT, naming the member and its value, for: a compression that is unknown or not in
 *  this library, a frameLevel outside of -2 (inherit), -1 (auto) and 0 to 8, a maxError that is not finite, a
 *  maxPixelError that is negative or not finite, an invalid camera with a maxPixelError above 0, or a fallbackFaces
 *  above 1. */
void validate(const CompressionSettings& settings);

/*! True if geometries with the settings store the same blocks of the same input. Ignores the progress function, the
 *  release of the input, and members that are set for devices only. */
bool selectSameBlocks(const CompressionSettings& a, const CompressionSettings& b);

/*! Returns the compression that a device selects if it is exact (cVERT, cTILE), else the preferred one. Thread safety:
 *  any thread may call it at any time. */
RTCCompression exactCompression(const Device* device);

/*! As rtcSetGeometryCompression. Settings that select the same blocks are no change of the geometry. Errors: as
 *  validate(); RTC_ERROR_INVALID_OPERATION for geometry of a type that cannot be compressed, and for geometry
 *  loaded from a file. An error changes nothing. Thread safety: no other thread may use the geometry during this
 *  call. Cost: constant. */
void setCompression(Geometry* geometry, const CompressionSettings& settings);

/*! True if a geometry has blocks. A changed geometry keeps them until its next commit. Thread safety: no other
 *  thread may commit the geometry or a scene that contains it during this call. Cost: constant. */
bool hasBlocks(Geometry* geometry);

/*! Returns why the last commit left a geometry to Embree's kernels although it requests compression: a static text
 *  that completes "its primitives ...", for example "are too few to matter". Null otherwise, and for a mesh without
 *  primitives or buffers. Thread safety: as hasBlocks(). */
const char* reasonNotCompressed(Geometry* geometry);

/*! Returns how many faces a geometry's blocks leave out, as Embree's subdivision does; 0 without blocks, and for
 *  geometry from a file. Thread safety: as hasBlocks(). Cost: constant. */
size_t numUnsupportedFaces(Geometry* geometry);

/*! Returns the statistics of the last commit of a scene, without instanced scenes; all zero if it has no compressed
 *  geometry. Errors: RTC_ERROR_INVALID_OPERATION if the scene or one of its enabled geometries was modified since
 *  its last commit. Thread safety: no other thread may change the scene during this call. Cost: constant per
 *  geometry. */
cbvh::CompressionStatistics statisticsOf(Scene* scene);
} // namespace core
} // namespace embree
