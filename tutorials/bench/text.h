// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "machine.h"
#include "options.h"
#include "results.h"

#include <string>

namespace programs {

std::string formatHead(const BenchOptions& options, const Machine& machine);

/* One line per variant, each followed by lines for checks and combinations. */
std::string formatTable(const Group& group);

} // namespace programs
