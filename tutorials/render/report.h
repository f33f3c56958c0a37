// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The numbers of a comparison as text. */

#include "comparison.h"

#include <string>

namespace cbvh {

/* A Markdown table of about a dozen rows, one column a representation, below what was run and
 * above where the pictures are. details: all rows. */
std::string formatTable(const Comparison& comparison, bool details);

/* The same numbers, unrounded, with units in the names. */
std::string formatJson(const Comparison& comparison);

} // namespace cbvh
