// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The speed of variants that are in memory together, measured in turns: each round
 * measures every variant once in every combination of view, ray set, query, mode and
 * threads. Variants follow one another directly, each round in another order, so a machine
 * that gets slower for a while slows all of them, and a ratio to GRID, or to another library,
 * is that of one round. */

#include "built_variant.h"
#include "options.h"
#include "views.h"

#include <string>
#include <vector>

namespace cbvh {

/* Adds a record for each combination to every variant's result, in the same order.
 *
 * views: that traced the variants. batch: GRID of each ISA and library first. title: of the phase.
 * Throws Cancelled. */
void measureSpeed(const BenchOptions& options, const std::vector<View>& views, const std::vector<BuiltVariant>& batch,
                  const std::string& title);

} // namespace cbvh
