// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Edge rates for a view: quads of about a pixel, or as large as requested (cbvhDiceSurface). */

#include "building/built_scene.h"
#include "building/edge_rates.h"
#include "tracing/camera.h"

#include <memory>
#include <optional>

namespace programs {

struct ViewDicing {
  float quadSize = 1; // pixels
  float maxRate = 4096;
};

/* Returns edge rates for a view: at most dicing.maxRate, and with a displacement map at most the number of texels along
 * the edge, or 64 if that is more. Uses threads and isa of the settings. Throws Error. */
std::shared_ptr<const EdgeRates> diceByView(const Model& model, const Camera& camera, const ViewDicing& dicing,
                                            const BuildSettings& settings);

/* Returns the settings with rates if `dicing` is set, and lattices with a spacing of at most `maxPixelError` pixels,
 * 0 for no bound. Throws Error. */
BuildSettings settingsForView(BuildSettings settings, const Model& model, const Camera& camera,
                              const std::optional<ViewDicing>& dicing, float maxPixelError);

/* Highest edge rate that all these representations support. */
float highestRate(const std::vector<Representation>& representations);

} // namespace programs
