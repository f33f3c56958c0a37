// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The run: builds one representation after the other, traces the same rays through each,
 * and collects what the table says. */

#include "model_view.h"
#include "speed.h"
#include "measure/hit_metrics.h"
#include "measure/true_errors.h"

#include <optional>
#include <string>
#include <vector>

namespace cbvh {

struct Result
{
  Representation representation;
  BuildReport build;
  std::optional<HitErrors> errors; // none for the reference itself, nor without one
  std::optional<TrueErrors> trueErrors;
  size_t anyDisagreements[numRaySets] = {0, 0};
  Speeds speed;
};

struct Comparison
{
  std::string model;
  size_t faces = 0, vertices = 0;
  BuildSettings build;
  ImageSize size;
  std::string camera;         // eye, target, field of view
  size_t primaryHits = 0;
  size_t rays[numRaySets] = {0, 0};
  bool speed = false;
  float quadSize = 0;         // in pixels where levels follow from the view, else 0
  bool isMesh = false;        // without levels
  bool compares = false;      // several representations
  std::string reference;      // what the errors are measured against, empty for no errors
  size_t trueHits = 0;        // compared with the true surface
  std::string pictures;       // lines that say where the pictures are and what they show
  std::vector<Result> results; // in the order asked for, without those that did not fit into memory
};

/* Runs everything and writes the pictures. Throws Error, Cancelled. */
Comparison runComparison(const Options& options, const ModelView& view);

} // namespace cbvh
