// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The C API of include/embree3/rtcore_dicing.h: checks pointers, calls operations/dicing.h, and reports its exceptions
 * to the device. */

#define RTC_EXPORT_API

#include "structs.h"
#include "../operations/dicing.h"

using namespace embree;

RTC_NAMESPACE_BEGIN;

RTC_API void rtcDiceGeometry(RTCGeometry hgeometry, const struct RTCDicingArguments* args) {
  Geometry* geometry = (Geometry*)hgeometry;
  RTC_CATCH_BEGIN;
  requireNotNull(geometry, "geometry");
  requireNotNull(args, "args");
  core::dice(geometry, dicingCamera(core::readStruct(args)));
  RTC_CATCH_END2(geometry);
}

RTC_NAMESPACE_END
