// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rates of edges by a view: quads are about a pixel, or as large as asked for, see embree3/rtcore_dicing.h. */

#include "building/built_scene.h"
#include "building/edge_rates.h"
#include "tracing/camera.h"

#include <memory>
#include <optional>

namespace cbvh {

struct ViewDicing
{
  float quadSize = 1; // pixels
  float maxRate = 4096;
};

/* Edges get no more quads than the map of the model has texels along them, but up to 64 wherever the surface wants them, which keeps what is
 * round round. settings: threads and isa count. Throws Error, Cancelled. */
std::shared_ptr<const EdgeRates> diceByView(const Model& model, const Camera& camera, const ViewDicing& dicing, const BuildSettings& settings);

/* Settings with a lattice as fine as the view needs, and with rates, if there is dicing. maxPixelError: of the lattice, 0 for no bound. Throws Error, Cancelled. */
BuildSettings settingsForView(BuildSettings settings, const Model& model, const Camera& camera, const std::optional<ViewDicing>& dicing, float maxPixelError);

/* The highest rate that all of a list of representations have blocks for. */
float highestRate(const std::vector<Representation>& representations);

} // namespace cbvh
