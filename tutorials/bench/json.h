// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Formats measurements as JSON. */

#include "machine.h"
#include "options.h"
#include "results.h"

#include <string>
#include <vector>

namespace cbvh {

/* Returns all results, with units in the names, and everything that is necessary to repeat the measurement. `complete`
 * is true if all groups are included. */
std::string formatJson(const BenchOptions& options, const Machine& machine, const std::vector<Group>& groups,
                       bool complete);

/* Returns the commit, the instruction sets that library and processor have, and the scenes. */
std::string formatAbout(const Machine& machine);

} // namespace cbvh
