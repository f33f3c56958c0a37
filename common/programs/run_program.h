// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>

namespace programs {

/* Returns the result of `run`, 130 after a cancellation, or 1 after an error, which prints one line on stderr that
 * starts with `name`. A failure to write standard output is an error. */
int runProgram(const char* name, const std::function<int()>& run);

} // namespace programs
