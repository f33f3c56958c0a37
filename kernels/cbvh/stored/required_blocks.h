// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "surface_blocks.h"
#include "../embree/scene.h"

namespace embree
{
  [[noreturn]] inline void throwNotCompressed () {
    throw_RTCError(RTC_ERROR_INVALID_OPERATION,
        "the geometry has not been compressed: it asks for no compression, or its scene has not been committed");
  }

  /*! Blocks of a geometry, valid until its next commit. Throws RTC_ERROR_INVALID_OPERATION if it has none. */
  inline const SurfaceBlocks& requireBlocks (Geometry* geometry)
  {
    const CompressibleGeometry* const compressible = asCompressible(geometry);
    if (!compressible || !compressible->surface.blocks) throwNotCompressed();
    return *compressible->surface.blocks;
  }
}
