// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "options.h"
#include "results.h"

#include <functional>

namespace programs {

/* Calls done(group) after each group. Throws Error. */
void runBenchmark(const BenchOptions& options, const std::function<void(const Group&)>& done);

} // namespace programs
