// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Measures variants that are in memory together. Each round measures every variant in every combination of view, ray
 * set, query, mode and threads, directly after one another and in changing order. So if the machine slows down, all
 * variants are affected, and ratios are computed within one round. */

#include "built_variant.h"
#include "options.h"
#include "views.h"

#include <string>
#include <vector>

namespace cbvh {

/* Adds a record per combination to every variant's result, in the same order. `batch` begins with GRID of each ISA
 * and library; `title` names the phase. Throws Canceled. */
void measureSpeed(const BenchOptions& options, const std::vector<View>& views, const std::vector<BuiltVariant>& batch,
                  const std::string& title);

} // namespace cbvh
