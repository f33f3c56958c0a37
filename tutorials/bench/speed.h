// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Measures the speed of variants that are in memory together. Each round measures every variant once in every
 * combination of view, ray set, query, mode and threads. Variants are measured directly after one another, in a
 * different order in each round. So if the machine slows down for some time, all variants are affected, and a ratio to
 * GRID, or to another library, is computed within one round. */

#include "built_variant.h"
#include "options.h"
#include "views.h"

#include <string>
#include <vector>

namespace cbvh {

/* Adds a record for each combination to every variant's result, in the same order. `views` belong to the variants;
 * `batch` begins with GRID of each ISA and library; `title` names the phase. Throws Canceled. */
void measureSpeed(const BenchOptions& options, const std::vector<View>& views, const std::vector<BuiltVariant>& batch,
                  const std::string& title);

} // namespace cbvh
