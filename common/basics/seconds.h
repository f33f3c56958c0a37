// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <chrono>

namespace cbvh {

/* What run() takes, by the clock. */
template<typename Run>
double secondsOf(const Run& run)
{
  const auto before = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - before).count();
}

} // namespace cbvh
