// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The C API of include/embree3/rtcore_surface.h: objects of cbvh.h for those of Embree, and back. libembree_cbvh, which
 * is linked from the same objects, does not export it. */

#define RTC_EXPORT_API

#include "points.h"
#include "surface.h"

#include "cbvh/operations/closest_point.h"
#include "cbvh/operations/device.h"

#include <embree3/rtcore_surface.h>

using namespace embree::capi;

namespace {

/* Returns closure(), or NULL or false after an exception, which it reports to the device, or to the thread if it is
 * NULL. */
template<typename Closure>
auto reportingTo(RTCDevice device, const Closure& closure) -> decltype(closure()) {
  try {
    return closure();
  } catch (...) { raise(device, caughtFailure()); }
  return {};
}

} // namespace

RTC_NAMESPACE_BEGIN

RTC_API CbvhContext rtcNewContextFromDevice(RTCDevice device) {
  return reportingTo(device, [&] {
    require(device, "device is NULL");
    return new CbvhContextTy(device);
  });
}

RTC_API CbvhSurface rtcNewSurfaceFromGeometry(RTCGeometry geometry) {
  const RTCDevice device = geometry ? (RTCDevice)embree::core::deviceOf((embree::Geometry*)geometry) : nullptr;
  return reportingTo(device, [&] {
    require(geometry, "geometry is NULL");
    const NewPtr<CbvhContextTy> context(new CbvhContextTy(device));
    return new CbvhSurfaceTy(context.get(), geometry);
  });
}

RTC_API RTCGeometry rtcNewGeometryFromSurface(RTCDevice device, CbvhSurface surface) {
  return reportingTo(device, [&] {
    require(device, "device is NULL");
    require(surface, "surface is NULL");
    require(surface->isOurs(), "the surface is of libembree_cbvh: expected one of libembree3");
    require(surface->context->device == device,
            "the surface belongs to another device: expected a context of rtcNewContextFromDevice for this device");
    const std::shared_ptr<const Input> input = surface->committedInput();
    if (input->displacement)
      rtcSetGeometryUserData(input->geometry, nullptr); // the displacement function is not called again
    rtcRetainGeometry(input->geometry);
    return input->geometry;
  });
}

RTC_API bool rtcFindClosestPoint(RTCScene scene, const CbvhPointQuery* query, CbvhClosestPoint* closest) {
  const RTCDevice device = scene ? (RTCDevice)embree::core::deviceOf((embree::Scene*)scene) : nullptr;
  return reportingTo(device, [&] {
    require(scene && query, "scene or query is NULL");
    embree::core::requireCommitted((embree::Scene*)scene);
    return queryPoint(scene, query, closest);
  });
}

RTC_NAMESPACE_END
