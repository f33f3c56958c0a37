// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a run of cbvh_bench finds. */

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

/* Of a variant in a view, a ray set, a query, a mode and a number of threads. */
struct Speed
{
  std::string view;
  RaySet set = Coherent;
  TraceSettings trace;
  size_t rays = 0, hits = 0;
  std::vector<double> seconds; // one a round
  std::vector<double> toGrid;  // speed over that of GRID on the same ISA by the same library in the same round
  std::vector<double> toFirst; // over that of the first library, if that has the same; of another library only

  double mrays(double s) const { return double(rays) * 1e-6 / s; }
};

/* Of a variant in a view, a ray set, a query and a mode: whether it hits what the first library
 * hits. */
struct HitAgreement
{
  std::string view;
  RaySet set = Coherent;
  TraceSettings trace;
  HitDifferences found;
};

/* Of a variant in a view. */
struct ViewResult
{
  std::string view;
  HitErrors errors;                         // primary rays, against GRID of the same level
  HitErrors away;                           // the same, of hits away from silhouettes
  std::optional<HitErrors> toReference;     // primary rays, against GRID of the reference level
  std::optional<TrueErrors> toTrue;         // primary rays, against the true surface
  std::optional<HeightBins> bins, binsAway; // of cLEAF-only at a given frame level; away from silhouettes
  HitErrors bounced;                        // incoherent rays, against GRID of the same level
  std::string picture, errorMap;            // file names
};

/* Of a representation on an instruction set, by a library. */
struct VariantResult
{
  Variant variant;
  std::string library;              // its name; empty where only the program's own is measured
  std::string skipped;              // why it was not measured, empty otherwise
  int batch = 0;                    // variants of a batch are measured in turns
  BuildReport build;
  size_t leafBytes = 0, innerBytes = 0;
  std::vector<ViewResult> views;
  std::vector<HitAgreement> agreements; // of another library than the first that has the same
  std::vector<Speed> speeds;
  CheckResult checks;
};

struct ViewInfo
{
  std::string name, camera;         // both as the --view option takes them
  size_t primaryHits = 0;
  size_t rays[numRaySets] = {0, 0};
};

/* A scene at a level: what is measured together. */
struct Group
{
  std::string scene;
  int level = 0;
  size_t faces = 0, quads = 0;
  double diagonal = 0;              // of the surface's bounding box
  double quadWidth = 0;             // mean length of an edge; 0 without checks
  std::vector<ViewInfo> views;
  std::deque<VariantResult> results; // in the order of building; none moves when others come
};

} // namespace cbvh
