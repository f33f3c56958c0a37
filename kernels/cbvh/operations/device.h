// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "errors.h"

namespace embree {
class Device;
class Geometry;
class Scene;

namespace core {
/*! As rtcNewDevice, but throws the reason of a failure; rtcNewDevice keeps only its code. Errors:
 *  RTC_ERROR_INVALID_ARGUMENT for invalid settings of compression, in the device string or in EMBREE_CBVH;
 *  RTC_ERROR_UNSUPPORTED_CPU. deviceString: may be null. The reference count is 1. Thread safety: any thread may
 *  call it at any time. */
Device* newDevice(const char* deviceString);

/*! Returns the device of a geometry or scene. */
Device* deviceOf(Geometry* geometry);
Device* deviceOf(Scene* scene);

/*! Returns the number of faces, grids, quads or triangles of a geometry. */
unsigned numPrimitives(Geometry* geometry);

/*! Reports an error as functions of rtcore.h do, to the device, or to the calling thread if it is null. */
void raiseError(Device* device, RTCError code, const char* text);
} // namespace core
} // namespace embree
