// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdio>
#include <sys/resource.h>
#include <unistd.h>

namespace programs::test {

/* Limits this process to `bytes` more than its present address space. Each thread needs 2 MiB or more for its stack. */
inline void limitAddressSpace(size_t bytes) {
  size_t pages = 0;
  if (FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%zu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  const rlim_t most = rlim_t(pages) * rlim_t(sysconf(_SC_PAGESIZE)) + bytes;
  const rlimit limit = {most, most};
  setrlimit(RLIMIT_AS, &limit);
}

} // namespace programs::test
