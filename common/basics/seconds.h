// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <chrono>
#include <ctime>

namespace programs {

/* Wall-clock time of run(), in seconds. */
template<typename Run>
double secondsOf(const Run& run) {
  const auto before = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
}

/* Processor time of run(), in seconds. `clock` is CLOCK_THREAD_CPUTIME_ID for the calling thread or
 * CLOCK_PROCESS_CPUTIME_ID for all threads. */
template<typename Run>
double processorSecondsOf(clockid_t clock, const Run& run) {
  const auto now = [&] {
    timespec time;
    clock_gettime(clock, &time);
    return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
  };
  const double before = now();
  run();
  return now() - before;
}

} // namespace programs
