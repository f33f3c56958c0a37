// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The machine and the build of a measurement. */

#include <cstddef>
#include <string>
#include <vector>

namespace cbvh {

struct Machine
{
  std::string cpu;
  unsigned threads = 0;         // hardware threads
  size_t memoryBytes = 0;
  double load = 0;               // mean number of runnable threads in the last minute, including other programs
  std::string system;            // name and release of the kernel
  std::string commit;            // of the build; "+changes" is appended for a modified working tree
  std::string compiler, flags, buildType;
  std::vector<std::string> isas; // that the library was built for
  std::string date;              // start of the program, as dateNow()
};

Machine describeMachine();

/* Returns the current time in UTC, ISO 8601. */
std::string dateNow();

/* Returns the instruction sets that both library and processor have, the narrowest first. */
std::vector<std::string> usableIsas(const Machine& machine);

/* Returns the widest usable instruction set, which Embree selects by default. Throws Error if there is none. */
std::string bestIsa(const Machine& machine);

/* Throws Error if a name is unknown, or if the library or the processor does not have the instruction set: Embree would
 * silently select another one. */
void requireIsa(const Machine& machine, const std::string& isa);

} // namespace cbvh
