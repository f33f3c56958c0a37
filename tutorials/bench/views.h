// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Views with the rays that every variant traces, and GRID's hits as the reference: it tests the same triangles as
 * NAIVE, but its edges are watertight. */

#include "options.h"
#include "results.h"
#include "building/built_scene.h"
#include "building/surface_hit.h"
#include "tracing/ray_sets.h"

#include <string>
#include <vector>

namespace programs {

/* All levels use its camera. */
struct ReferenceView {
  Camera camera;
  std::vector<SurfaceHit> gridHits;
};

struct View {
  explicit View(const Camera& camera) : camera(camera), primary(primaryRays(camera)) {}

  std::string name, fileName;
  Camera camera;
  const ReferenceView* reference = nullptr; // may be null
  std::vector<Ray> primary, sets[numRaySets];
  std::vector<SurfaceHit> gridHits;        // of the primary rays
  std::vector<SurfaceHit> bouncedGridHits; // of the incoherent set
  std::vector<size_t> sample;              // primary rays to compare with the true surface
};

/* Traces the views of the options with GRID at the reference level; returns none without that level. Throws Error. */
std::vector<ReferenceView> traceReference(const BenchOptions& options, const Model& model);

/* One entry per view of the options. `reference` must outlive the views. Throws Error. */
std::vector<View> makeViews(const BenchOptions& options, const Model& model, const BuiltScene& grid,
                            const std::vector<ReferenceView>& reference);

ViewInfo describe(const View& view);

} // namespace programs
