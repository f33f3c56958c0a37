// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Edge rates for a view: quads are about a pixel in size, or as large as requested; see embree3/rtcore_dicing.h. */

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

/* Returns edge rates for a view. An edge gets at most as many quads as the model's map has texels along it, or 64 if
 * that is more, which keeps smooth shapes round. Uses threads and isa of the settings. Throws Error, Cancelled. */
std::shared_ptr<const EdgeRates> diceByView(const Model& model, const Camera& camera, const ViewDicing& dicing,
                                            const BuildSettings& settings);

/* Returns the settings with a lattice as fine as the view requires, and with rates if `dicing` is set. `maxPixelError`
 * bounds the lattice, 0 for no bound. Throws Error, Cancelled. */
BuildSettings settingsForView(BuildSettings settings, const Model& model, const Camera& camera,
                              const std::optional<ViewDicing>& dicing, float maxPixelError);

/* Returns the highest rate that all of the representations support. */
float highestRate(const std::vector<Representation>& representations);

} // namespace cbvh
