// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Exceptions of the tools. runProgram prints what() as one line, so a message must name the file or the argument, and
 * its value. */

#include <stdexcept>
#include <string>

namespace programs {

struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/* Thrown after a cancellation (progress.h). */
struct Canceled : Error {
  Canceled() : Error("canceled") {}
};

} // namespace programs
