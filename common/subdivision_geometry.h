// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A model as Embree subdivision geometry at a uniform edge rate. */

#include "embree_device.h"
#include "model.h"

#include <vector>

namespace cbvh {

/* What the displacement function of a geometry needs; outlives the geometry. */
struct DisplacementContext
{
  const Displacement* displacement = nullptr;

  /* If set, every vertex that Embree tessellates is also written here, in the order
   * of the layout: the tessellation that GRID stores, to the bit. */
  const PatchLayout* layout = nullptr;
  float* captured = nullptr; // 3 floats a vertex
};

/* Makes the geometry, committed, not yet attached to a scene.
 *
 * level: edge rate 2^level. context: displacement and capture.
 * Errors: throws Error. */
GeometryHandle makeSubdivisionGeometry(EmbreeDevice& device, const Cage& cage, int level, DisplacementContext& context);

} // namespace cbvh
