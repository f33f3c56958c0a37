// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "surface_blocks.h"
#include "../embree/scene.h"
#include <string>

namespace embree {
/*! geometry: null if its type cannot be compressed. */
[[noreturn]] inline void throwNotCompressed(const CompressibleGeometry* geometry) {
  const char* const reason = geometry ? geometry->surface.rejectionReason : nullptr;
  const std::string why = !geometry ? "expected a subdivision surface, grids, quads or triangles"
                          : !reason ? "it asks for no compression, or its scene has not been committed"
                          : *reason ? std::string("its primitives ") + reason
                                    : "it has no vertices or no primitives";
  throw_RTCError(RTC_ERROR_INVALID_OPERATION, "the geometry has not been compressed: " + why);
}

/*! Blocks of a geometry, valid until its next commit. Throws RTC_ERROR_INVALID_OPERATION if it has none. */
inline const SurfaceBlocks& requireBlocks(Geometry* geometry) {
  const CompressibleGeometry* const compressible = asCompressible(geometry);
  if (!compressible || !compressible->surface.blocks) throwNotCompressed(compressible);
  return *compressible->surface.blocks;
}
} // namespace embree
