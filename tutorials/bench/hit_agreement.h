// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compares the hits of libraries. If a library differs from another only by optimizations, every ray must have the same
 * hit. Compares every query of Embree's API that is measured, because each has its own code. */

#include "built_variant.h"
#include "options.h"
#include "views.h"

#include <string>
#include <vector>

namespace cbvh {

/* Adds agreements to the results of all variants of other libraries than the first that have none yet. `title` names
 * the phase. Throws Canceled. */
void compareLibraries(const BenchOptions& options, const std::vector<View>& views,
                      const std::vector<BuiltVariant>& batch, const std::string& title);

} // namespace cbvh
