// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's functions as this program, including common/, calls them. The program defines them itself: each is one jump
 * through a slot, like an entry of a linker's table for a shared library, and costs the same. Unlike that table, slots
 * can be refilled, so several builds of the library can be in one process, one of which is current. */

#include <map>
#include <string>

namespace cbvh {

/* Addresses by name. Null if the library does not have the function. */
using EmbreeFunctions = std::map<std::string, void*>;

/* Finds the functions in a library that dlopen opened. */
EmbreeFunctions embreeFunctionsOf(void* opened);

/* Fills the slots. Calling a function that is null throws Error that names it and `library`. No other thread may call
 * Embree during this call. */
void useEmbreeFunctions(const EmbreeFunctions& functions, const std::string& library);

} // namespace cbvh
