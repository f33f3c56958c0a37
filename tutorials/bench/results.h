// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "batches.h"
#include "robustness.h"
#include "building/built_scene.h"
#include "measure/hit_metrics.h"
#include "measure/true_errors.h"
#include "tracing/hit_records.h"
#include "tracing/trace_timing.h"

#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace programs {

/* Speed for a view, a ray set, a query, a mode and a number of threads. */
struct Speed {
  std::string view;
  RaySet set = Coherent;
  TraceSettings trace;
  size_t rays = 0, hits = 0;
  std::vector<double> seconds; // per round
  std::vector<double> toGrid;  // relative to GRID on the same ISA, library and round
  std::vector<double> toFirst; // relative to the first library; empty if that is this one or lacks it

  double mrays(double s) const { return double(rays) * 1e-6 / s; }
};

/* Agreement with the first library, for a view, a ray set, a query and a mode. */
struct HitAgreement {
  std::string view;
  RaySet set = Coherent;
  TraceSettings trace;
  HitDifferences differences;
};

struct ViewResult {
  std::string view;
  HitErrors errors;                     // primary rays, against GRID at the same level
  std::optional<HitErrors> toReference; // primary rays, against GRID at the reference level
  std::optional<TrueErrors> toTrue;     // primary rays, against the true surface
  HitErrors bounced;                    // incoherent rays, against GRID at the same level
  std::string picture, errorMap;        // file names
};

struct VariantResult {
  Variant variant;
  std::string library; // name; empty if only the program's own library is measured
  std::string skipped; // reason why it was not measured, or empty
  int batch = 0;       // a batch is measured alternately
  BuildReport build;
  size_t leafBytes = 0, innerBytes = 0;
  std::vector<ViewResult> views;
  std::vector<HitAgreement> agreements; // with the first library
  std::vector<Speed> speeds;
  CheckResult checks;
};

struct ViewInfo {
  std::string name, camera; // as for --view
  size_t primaryHits = 0;
  size_t rays[numRaySets] = {0, 0};
};

/* Its variants are measured together. */
struct Group {
  std::string scene;
  int level = 0;
  size_t faces = 0, quads = 0;
  double diagonal = 0;  // of the surface's bounding box
  double quadWidth = 0; // mean edge length; 0 without checks
  std::vector<ViewInfo> views;
  std::deque<VariantResult> results; // in the order of building; addresses stay valid
};

} // namespace programs
