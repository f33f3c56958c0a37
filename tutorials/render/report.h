// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Formats the numbers of a comparison. */

#include "comparison.h"

#include <string>

namespace cbvh {

/* Returns a description of the run, a Markdown table with one column per representation, and the paths of the pictures.
 * The table has about a dozen rows, or all rows if `details` is set. */
std::string formatTable(const Comparison& comparison, bool details);

/* Returns the same numbers as JSON, unrounded, with units in the names. */
std::string formatJson(const Comparison& comparison);

} // namespace cbvh
