// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the tools throw. A program catches it once, in runProgram, and prints what() as
 * one line on stderr, so a message names the file or argument and its value. */

#include <stdexcept>
#include <string>

namespace cbvh {

struct Error : std::runtime_error
{
  using std::runtime_error::runtime_error;
};

/* The user pressed Ctrl-C. */
struct Cancelled : Error
{
  Cancelled() : Error("cancelled") {}
};

} // namespace cbvh
