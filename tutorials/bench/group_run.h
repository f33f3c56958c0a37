// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Builds the variants of a scene at a level batch by batch, compares and measures them. */

#include "options.h"
#include "results.h"
#include "views.h"
#include "surface/true_surface.h"

namespace cbvh {

struct GroupSettings
{
  const BenchOptions& options;
  std::string scene; // its label
  const Model& model;
  const TrueSurfaces* surfaces; // of the model; null to skip errors against the true surface
  const std::vector<ReferenceView>& reference; // of the model
  int level;
};

/* Runs a group. Throws Error. */
Group runGroup(const GroupSettings& settings);

} // namespace cbvh
