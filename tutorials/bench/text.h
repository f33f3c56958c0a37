// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Formats measurements for a terminal. */

#include "machine.h"
#include "options.h"
#include "results.h"

#include <string>

namespace cbvh {

/* Returns some lines about the machine and the build. */
std::string formatHead(const BenchOptions& options, const Machine& machine);

/* Returns one line per variant, followed by one line per check and per combination. */
std::string formatTable(const Group& group);

} // namespace cbvh
