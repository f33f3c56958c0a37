// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Each round measures all variants in memory, in every combination of view, ray set, query, mode and threads, one after
 * another in changing order. If the machine slows down, it affects all, and ratios are computed within a round. */

#include "built_variant.h"
#include "options.h"
#include "views.h"

#include <string>
#include <vector>

namespace programs {

/* Adds a record per combination to every variant's result, in the same order. `batch` begins with GRID of each ISA
 * and library; `title` names the phase. Throws Canceled. */
void measureSpeed(const BenchOptions& options, const std::vector<View>& views, const std::vector<BuiltVariant>& batch,
                  const std::string& title);

} // namespace programs
