// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Libraries that differ only by optimizations must find the same hits, for every query that is measured. */

#include "built_variant.h"
#include "options.h"
#include "views.h"

#include <string>
#include <vector>

namespace programs {

/* Adds agreements with the first library to variants of other libraries that have none. `title` names the phase.
 * Throws Canceled. */
void compareLibraries(const BenchOptions& options, const std::vector<View>& views,
                      const std::vector<BuiltVariant>& batch, const std::string& title);

} // namespace programs
