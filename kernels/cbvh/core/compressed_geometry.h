// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Which geometries the functions of this folder accept. For their sources only: interfaces do not include Embree's
 * internals. */

#include "../embree/scene.h"
#include "../stored/surface_blocks.h"
#include "loaded_geometry.h"

namespace embree
{
  namespace core
  {
    [[noreturn]] inline void notCompressed () {
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,
          "the geometry has not been compressed: it asks for no compression, or neither it nor its scene was "
          "committed");
    }

    /*! Returns the blocks of a geometry, which keeps them until its next commit. Throws if it has none. */
    inline const SurfaceBlocks& requireBlocks (Geometry* geometry)
    {
      const CompressibleGeometry* const surface = compressible(geometry);
      if (!surface || !surface->surface.blocks) notCompressed();
      return *surface->surface.blocks;
    }

    /*! Throws for a geometry of a file. */
    inline void requireEditable (Geometry* geometry) {
      if (dynamic_cast<const LoadedGeometry*>(geometry)) throw_RTCError(RTC_ERROR_INVALID_OPERATION,
          LoadedGeometry::whyNot);
    }
  }
}
