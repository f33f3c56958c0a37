// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Results of a run of cbvh_bench. */

#include "batches.h"
#include "robustness.h"
#include "building/built_scene.h"
#include "measure/height_bins.h"
#include "measure/hit_metrics.h"
#include "measure/true_errors.h"
#include "tracing/kept_hits.h"
#include "tracing/trace_timing.h"

#include <deque>
#include <optional>
#include <string>
#include <vector>

namespace cbvh {

/* Speed of a variant in a view, for a ray set, a query, a mode and a number of threads. */
struct Speed
{
  std::string view;
  RaySet set = Coherent;
  TraceSettings trace;
  size_t rays = 0, hits = 0;
  std::vector<double> seconds; // per round
  std::vector<double> toGrid;  // speed relative to GRID on the same ISA, by the same library, in the same round
  std::vector<double> toFirst; // relative to the first library; empty if this is the first or the first lacks it

  double mrays(double s) const { return double(rays) * 1e-6 / s; }
};

/* Agreement of a variant with the first library in a view, for a ray set, a query and a mode. */
struct HitAgreement
{
  std::string view;
  RaySet set = Coherent;
  TraceSettings trace;
  HitDifferences found;
};

/* Errors of a variant in a view. */
struct ViewResult
{
  std::string view;
  HitErrors errors;                         // primary rays, against GRID at the same level
  HitErrors away;                           // the same, for hits away from silhouettes
  std::optional<HitErrors> toReference;     // primary rays, against GRID at the reference level
  std::optional<TrueErrors> toTrue;         // primary rays, against the true surface
  std::optional<HeightBins> bins, binsAway; // only for cLEAF-only with a given frame level; away from silhouettes
  HitErrors bounced;                        // incoherent rays, against GRID at the same level
  std::string picture, errorMap;            // file names
};

/* Results of a representation on an instruction set, by a library. */
struct VariantResult
{
  Variant variant;
  std::string library; // its name; empty if only the program's own library is measured
  std::string skipped; // why it was not measured, otherwise empty
  int batch = 0;       // variants of a batch are measured alternately
  BuildReport build;
  size_t leafBytes = 0, innerBytes = 0;
  std::vector<ViewResult> views;
  std::vector<HitAgreement> agreements; // with the first library, if this is another one
  std::vector<Speed> speeds;
  CheckResult checks;
};

struct ViewInfo
{
  std::string name, camera; // both in the syntax of --view
  size_t primaryHits = 0;
  size_t rays[numRaySets] = {0, 0};
};

/* A scene at a level. Its variants are measured together. */
struct Group
{
  std::string scene;
  int level = 0;
  size_t faces = 0, quads = 0;
  double diagonal = 0;              // of the surface's bounding box
  double quadWidth = 0;             // mean length of edges; 0 without checks
  std::vector<ViewInfo> views;
  std::deque<VariantResult> results; // in the order of building; a deque keeps addresses valid
};

} // namespace cbvh
