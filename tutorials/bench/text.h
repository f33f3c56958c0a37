// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Measurements as text for a terminal. */

#include "machine.h"
#include "options.h"
#include "results.h"

#include <string>

namespace cbvh {

/* A few lines about the machine and the build. */
std::string formatHead(const BenchOptions& options, const Machine& machine);

/* One line a variant, and below it one for each check and each combination. */
std::string formatTable(const Group& group);

} // namespace cbvh
