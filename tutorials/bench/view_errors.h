// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How far the hits of a variant in a view lie from those of other surfaces. */

#include "views.h"
#include "surface/true_surface.h"

namespace cbvh {

/* What all variants of a group have in common. */
struct ErrorSettings
{
  const Model& model;
  const TrueSurfaces* surfaces; // of the model, null for no errors against it
  int level;                    // of the group
  unsigned threads;
};

/* Of primary and bounced rays. hits: those of the primary rays in the scene. Throws
 * Cancelled. */
ViewResult errorsInView(const ErrorSettings& settings, const View& view, const BuiltScene& scene,
                        const std::vector<SurfaceHit>& hits);

} // namespace cbvh
