// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <atomic>
#include <limits>
#include <sys/types.h>

namespace programs::test {

struct Memory {
  std::atomic<ssize_t> live{0}, peak{0};
  std::atomic<ssize_t> most{std::numeric_limits<ssize_t>::max()}; // the monitor rejects allocations beyond this limit

  static bool monitor(void* self, ssize_t bytes, bool post) {
    Memory& m = *(Memory*)self;
    if (bytes > 0 && !post && m.live + bytes > m.most) return false;
    const ssize_t live = m.live += bytes;
    ssize_t peak = m.peak;
    while (live > peak && !m.peak.compare_exchange_weak(peak, live)) {}
    return true;
  }
};

} // namespace programs::test
