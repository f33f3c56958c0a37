// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Catches the exceptions of a program. */

#include <functional>

namespace cbvh {

/* Runs a program. Returns the exit status: the result of `run`, 130 if the user canceled it, or 1 after an error. An
 * error prints one line on stderr that starts with the program's name. Failing to write standard output is an error. */
int runProgram(const char* name, const std::function<int()>& run);

} // namespace cbvh
