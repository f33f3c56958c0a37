// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The one place where programs catch what is thrown. */

#include <functional>

namespace cbvh {

/* All that main() does. Returns the exit status: what `run` returns; 130 where the user cancelled it; 1 for every
 * error, of which stderr gets a line that starts with the program's name. Standard output that cannot be written is an
 * error, too. */
int runProgram(const char* name, const std::function<int()>& run);

} // namespace cbvh
