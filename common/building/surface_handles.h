// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Owners of objects of cbvh.h. Errors of objects that belong to a device are those of the device: EmbreeDevice::check()
 * throws them. */

#include <embree3/rtcore_surface.h>

#include <memory>

namespace programs {

struct SurfaceObjectRelease {
  void operator()(CbvhContext context) const { cbvhReleaseContext(context); }
  void operator()(CbvhSurface surface) const { cbvhReleaseSurface(surface); }
  void operator()(CbvhFile file) const { cbvhReleaseFile(file); }
  void operator()(CbvhFileWriter writer) const { cbvhReleaseFileWriter(writer); }
};

using ContextHandle = std::unique_ptr<CbvhContextTy, SurfaceObjectRelease>;
using SurfaceHandle = std::unique_ptr<CbvhSurfaceTy, SurfaceObjectRelease>;
using FileHandle = std::unique_ptr<CbvhFileTy, SurfaceObjectRelease>;
using FileWriterHandle = std::unique_ptr<CbvhFileWriterTy, SurfaceObjectRelease>;

inline ContextHandle contextOf(RTCDevice device) { return ContextHandle(rtcNewContextFromDevice(device)); }
inline SurfaceHandle surfaceOf(RTCGeometry geometry) { return SurfaceHandle(rtcNewSurfaceFromGeometry(geometry)); }

} // namespace programs
