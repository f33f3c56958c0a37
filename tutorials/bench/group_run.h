// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Builds, compares and measures the variants of a scene at a level. */

#include "options.h"
#include "results.h"
#include "views.h"
#include "surface/true_surface.h"

namespace programs {

struct GroupSettings {
  const BenchOptions& options;
  std::string scene; // label
  const Model& model;
  const TrueSurfaces* surfaces; // null to skip errors against the true surface
  const std::vector<ReferenceView>& reference;
  int level;
};

/* Throws Error. */
Group runGroup(const GroupSettings& settings);

} // namespace programs
