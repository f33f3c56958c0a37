// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Measurements as JSON. */

#include "machine.h"
#include "options.h"
#include "results.h"

#include <string>
#include <vector>

namespace cbvh {

/* Everything, with units in the names and what it takes to measure it again.
 * complete: whether all groups that were asked for are there. */
std::string formatJson(const BenchOptions& options, const Machine& machine, const std::vector<Group>& groups,
                       bool complete);

/* Commit, instruction sets that library and processor have, and scenes. */
std::string formatAbout(const Machine& machine);

} // namespace cbvh
