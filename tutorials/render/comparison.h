// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Builds one representation after the other; all trace the same rays. */

#include "model_view.h"
#include "speed.h"
#include "measure/hit_metrics.h"
#include "measure/true_errors.h"

#include <optional>
#include <string>
#include <vector>

namespace programs {

struct Result {
  Representation representation;
  BuildReport build;
  std::optional<HitErrors> errors; // unset for the reference itself, and without one
  std::optional<TrueErrors> trueErrors;
  size_t anyDisagreements[numRaySets] = {0, 0};
  Speeds speed;
};

struct Comparison {
  std::string model;
  size_t faces = 0, vertices = 0;
  BuildSettings build;
  ImageSize size;
  std::string camera; // eye, target, field of view
  size_t primaryHits = 0;
  size_t rays[numRaySets] = {0, 0};
  bool speed = false;
  float quadSize = 0;          // pixels; 0 if the view does not determine levels
  bool isMesh = false;         // without levels
  bool compares = false;       // there are several representations
  std::string reference;       // of the errors; empty without GRID and NAIVE
  size_t trueHits = 0;         // compared with the true surface
  std::string pictures;        // paths and contents
  std::vector<Result> results; // in the order of the options
};

/* Measures all representations and writes the pictures. Throws Error. */
Comparison runComparison(const Options& options, const ModelView& view);

} // namespace programs
