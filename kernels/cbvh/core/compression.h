// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How geometries are compressed, and what came of it. */

#include "../base/surface_statistics.h"
#include "../state/settings.h"

namespace embree
{
  class Geometry;
  class Scene;

  namespace core
  {
    /*! Throws RTC_ERROR_INVALID_ARGUMENT, with the name of the member and its value, for an unknown compression, or one
     *  that this library was built without, a frameLevel outside of -2 to 8, a maxError that is not finite, a
     *  maxPixelError that is negative or not finite, a camera without which it means nothing, and an exactFaces above
     *  1. */
    void validate (const CompressionSettings& settings);

    /*! Chooses how a geometry is stored, by its next commit (releasesInput) or by the next commit of its scene. Blocks
     *  that exist are built again then. Errors: those of validate(); RTC_ERROR_INVALID_OPERATION unless it is a
     *  subdivision surface, grids, quads or triangles, and for a geometry of a file. The geometry keeps its settings if
     *  there is an error. Thread safety: no other thread may use the geometry meanwhile. Cost: constant. */
    void setCompression (Geometry* geometry, const CompressionSettings& settings);

    /*! Returns true if a geometry is stored as blocks: it was compressed by its own commit, or by the commit of a
     *  scene, and not changed since then. Thread safety: no other thread may commit the geometry meanwhile. Cost:
     *  constant. */
    bool hasBlocks (Geometry* geometry);

    /*! Returns why a geometry that asks for compression was left to Embree's kernels by its last commit, as the end of
     *  a sentence: "are too few to matter". Null if it was not, or if it has no primitives. The text is of static
     *  storage. */
    const char* whyNotCompressed (Geometry* geometry);

    /*! Returns what the last commit of a scene compressed; all zero if the scene has no compressed geometry. Geometry
     *  of instanced scenes belongs to those scenes. Errors: RTC_ERROR_INVALID_OPERATION if the scene or one of its
     *  geometries was modified since its last commit. Thread safety: any thread, but no other may change the scene
     *  meanwhile. Cost: constant per geometry. */
    cbvh::CompressionStatistics statisticsOf (Scene* scene);
  }
}
