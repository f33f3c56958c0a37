// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Errors of the hits of a variant in a view, against several references. */

#include "views.h"
#include "surface/true_surface.h"

namespace cbvh {

/* Settings for all variants of a group. */
struct ErrorSettings
{
  const Model& model;
  const TrueSurfaces* surfaces; // of the model; null to skip errors against the true surface
  int level;                    // of the group
  unsigned threads;
};

/* Compares primary and bounced rays. `hits` are the hits of the primary rays in the scene. Throws Canceled. */
ViewResult errorsInView(const ErrorSettings& settings, const View& view, const BuiltScene& scene,
                        const std::vector<SurfaceHit>& hits);

} // namespace cbvh
