// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "views.h"
#include "surface/true_surface.h"

namespace programs {

struct ErrorSettings {
  const Model& model;
  const TrueSurfaces* surfaces; // null to skip errors against the true surface
  unsigned threads;
};

/* `hits` belong to the primary rays. Throws Canceled. */
ViewResult errorsInView(const ErrorSettings& settings, const View& view, const BuiltScene& scene,
                        const std::vector<SurfaceHit>& hits);

} // namespace programs
