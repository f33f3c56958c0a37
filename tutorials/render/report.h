// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "comparison.h"

#include <string>

namespace programs {

/* A description of the run, a Markdown table (about a dozen rows, or all if `details`), and the paths of the
 * pictures. */
std::string formatTable(const Comparison& comparison, bool details);

/* The same numbers, unrounded. */
std::string formatJson(const Comparison& comparison);

} // namespace programs
