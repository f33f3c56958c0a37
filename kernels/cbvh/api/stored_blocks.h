// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The blocks of a geometry for functions of the API that hand out what is stored. */

#include "../embree/scene.h"
#include "../stored/stored_triangles.h"
#include "../stored/surface_blocks.h"

namespace embree
{
  /*! Throws where there is none, and where that was not compressed. */
  inline const SurfaceBlocks& storedBlocksOf (RTCGeometry hgeometry)
  {
    if (hgeometry == nullptr)
      throw_RTCError(RTC_ERROR_INVALID_ARGUMENT,"geometry is NULL");
    const CompressibleGeometry* const geometry = compressible((Geometry*)hgeometry);
    if (!geometry || !geometry->surface.blocks)
      throw_RTCError(RTC_ERROR_INVALID_OPERATION,"the geometry has not been compressed: it asks for no compression, or neither it nor its scene was committed");
    return *geometry->surface.blocks;
  }

  inline cbvh::TraversalTime traversalTime (Geometry* geometry, float time) {
    return cbvh::TraversalTime{ time,(geometry->device->enabled_cpu_features & AVX2) == AVX2 };
  }
}
