// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The program defines Embree's functions itself: each jumps through a slot, at the cost of an entry of a linker's
 * table for a shared library. Slots can be refilled, so a process may contain several builds of the library; one of
 * them is current. */

#include <map>
#include <string>

namespace programs {

/* Addresses by name; null if the library lacks the function. */
using EmbreeFunctions = std::map<std::string, void*>;

/* `opened` is a library opened by dlopen. */
EmbreeFunctions embreeFunctionsOf(void* opened);

/* Fills the slots. Calling a null function throws Error with its name and `library`. No other thread may call Embree
 * during this call. */
void useEmbreeFunctions(const EmbreeFunctions& functions, const std::string& library);

} // namespace programs
