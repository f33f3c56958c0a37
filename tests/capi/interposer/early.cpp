// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A library whose static initializer creates a device and a geometry, which may happen before the interposer's static
 * initializers. A program that links it does nothing else. */

#include <embree4/rtcore.h>

namespace {

struct Early {
  RTCDevice device = rtcNewDevice("threads=1");
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);

  ~Early() {
    rtcReleaseGeometry(geometry);
    rtcReleaseDevice(device);
  }
} early;

} // namespace
