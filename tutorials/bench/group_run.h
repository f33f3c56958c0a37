// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A scene at a level: its variants built batch by batch, compared and measured. */

#include "options.h"
#include "results.h"
#include "views.h"
#include "surface/true_surface.h"

namespace cbvh {

struct GroupSettings
{
  const BenchOptions& options;
  std::string scene;                           // its label
  const Model& model;
  const TrueSurfaces* surfaces;                // of the model, null for no errors against it
  const std::vector<ReferenceView>& reference; // of the model
  int level;
};

/* Throws Error, Cancelled. */
Group runGroup(const GroupSettings& settings);

} // namespace cbvh
