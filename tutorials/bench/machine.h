// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace programs {

struct Machine {
  std::string cpu;
  unsigned threads = 0; // of the hardware
  size_t memoryBytes = 0;
  double load = 0;    // runnable threads in the last minute
  std::string system; // kernel name, release and processor type
  std::string commit; // of the build; ends in "+changes" for a modified working tree
  std::string compiler, flags, buildType;
  std::vector<std::string> isas; // of the library
  std::string date;
};

Machine describeMachine();

/* Current time in UTC, ISO 8601. */
std::string dateNow();

/* Instruction sets of both library and processor, narrowest first. */
std::vector<std::string> usableIsas(const Machine& machine);

/* The widest usable one, Embree's default. Throws Error if there is none. */
std::string bestIsa(const Machine& machine);

/* Throws Error unless library and processor have the instruction set: Embree would silently select another. */
void requireIsa(const Machine& machine, const std::string& isa);

} // namespace programs
