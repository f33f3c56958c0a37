// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The numbers of a comparison as text. */

#include "comparison.h"

#include <string>

namespace cbvh {

/* A Markdown table, one column a representation, with a line about the run above. */
std::string formatTable(const Comparison& comparison);

/* The same numbers, unrounded, with units in the names. */
std::string formatJson(const Comparison& comparison);

} // namespace cbvh
