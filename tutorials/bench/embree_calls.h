// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's functions as this program and what it has of common/ call them: the program has
 * them itself. Each is one jump to where a slot says, as it is in the table that a linker makes
 * for the functions of a shared library, and costs the same, but these slots can be filled
 * again: so several builds of the library can be in one process, one of them in use. */

#include <map>
#include <string>

namespace cbvh {

/* By name. Null: the library does not have it. */
using EmbreeFunctions = std::map<std::string, void*>;

/* Finds them all in a library that dlopen opened. */
EmbreeFunctions embreeFunctionsOf(void* opened);

/* Fills the slots. To call a function that is null throws Error, which says so. No other
 * thread calls Embree meanwhile. library: its name in that Error. */
void useEmbreeFunctions(const EmbreeFunctions& functions, const std::string& library);

} // namespace cbvh
