// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Whether libraries hit the same: where one is a change of the other that is to be faster and
 * nothing else, every ray has to. Each entrance of Embree's API is looked at that is measured,
 * for it has code of its own. */

#include "built_variant.h"
#include "options.h"
#include "views.h"

#include <string>
#include <vector>

namespace cbvh {

/* Adds agreements to the results of all variants of other libraries that have none yet. title:
 * of the phase. Throws Cancelled. */
void compareLibraries(const BenchOptions& options, const std::vector<View>& views,
                      const std::vector<BuiltVariant>& batch, const std::string& title);

} // namespace cbvh
