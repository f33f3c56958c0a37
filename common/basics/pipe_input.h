// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reads from named pipes and from a shell's <(command). */

#include <array>
#include <streambuf>
#include <string>

namespace programs {

bool isPipe(const std::string& path);

class PipeInput : public std::streambuf {
public:
  /* Opens a pipe without waiting for a writer. Throws Error. */
  explicit PipeInput(const std::string& path);
  ~PipeInput() override;
  PipeInput(const PipeInput&) = delete;
  PipeInput& operator=(const PipeInput&) = delete;

protected:
  /* Waits up to 10 seconds for a program that opens the pipe for writing. Throws Error. */
  int_type underflow() override;

private:
  std::string path;
  int file = -1;
  bool hadWriter = false;
  std::array<char, 1 << 16> buffer;
};

} // namespace programs
