// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "machine.h"
#include "options.h"
#include "results.h"

#include <string>
#include <vector>

namespace programs {

/* Includes everything that is necessary to repeat the run. `complete` is true if all groups are included. */
std::string formatJson(const BenchOptions& options, const Machine& machine, const std::vector<Group>& groups,
                       bool complete);

/* Commit, usable instruction sets and scenes. */
std::string formatAbout(const Machine& machine);

} // namespace programs
