// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a measurement ran on, and what it was built from. */

#include <cstddef>
#include <string>
#include <vector>

namespace cbvh {

struct Machine
{
  std::string cpu;
  unsigned threads = 0;         // hardware threads
  size_t memoryBytes = 0;
  double load = 0;              // runnable threads in the last minute, other programs' included
  std::string system;           // kernel's name and release
  std::string commit;           // of what was built; "+changes" for a changed working tree
  std::string compiler, flags, buildType;
  std::vector<std::string> isas; // that the library was built for
  std::string date;             // as dateNow(), of the start
};

Machine describeMachine();

/* UTC, ISO 8601. */
std::string dateNow();

/* What both library and processor have, narrowest first. */
std::vector<std::string> usableIsas(const Machine& machine);

/* The instruction set that Embree picks when nothing is asked for, the widest of them. Throws Error
 * if there is none. */
std::string bestIsa(const Machine& machine);

/* Throws Error for a name that is unknown, or that the library or the processor
 * does not have: Embree would quietly take another. */
void requireIsa(const Machine& machine, const std::string& isa);

} // namespace cbvh
