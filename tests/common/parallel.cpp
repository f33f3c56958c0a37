// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "basics/parallel.h"
#include "basics/error.h"
#include "support/address_space.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>

namespace programs::test { namespace {

TEST(Parallel, RangesCoverAllIndicesOnce) {
  for (size_t n : {0, 1, 63, 1000})
    for (size_t chunk : {1, 7, 5000})
      for (unsigned threads : {1u, 3u}) {
        std::vector<std::atomic<int>> calls(n);
        parallelFor(n, chunk, threads, [&](size_t begin, size_t end) {
          EXPECT_LE(end - begin, chunk);
          for (size_t i = begin; i < end; i++) calls[i]++;
        });
        for (const auto& count : calls) ASSERT_EQ(count, 1);
      }
}

TEST(Parallel, RunsOnTheThreadsThatTheSystemCreates) {
  const auto child = [] {
    limitAddressSpace(size_t(64) << 20);
    std::atomic<size_t> sum{0};
    parallelFor(1000, 1, 10000, [&](size_t begin, size_t) { sum += begin; });
    std::_Exit(sum == 999 * 1000 / 2 ? 0 : 1);
  };
  EXPECT_EXIT(child(), testing::ExitedWithCode(0), "");
}

TEST(Parallel, CancellationStopsAllThreadsOfItsLoopOnly) {
  Cancellation canceled, other;
  const auto loop = [](const Cancellation& cancellation, Cancellation& request) {
    const CancellationScope scope(&cancellation);
    std::atomic<size_t> calls{0};
    parallelFor(5000, 1, 3, [&](size_t, size_t) {
      if (++calls == 10) request.request();
    });
    return calls.load();
  };
  EXPECT_THROW(loop(canceled, canceled), Canceled);
  EXPECT_EQ(loop(other, canceled), 5000u);
  EXPECT_EQ(CancellationScope::current(), nullptr);
  EXPECT_FALSE(cancelRequested());
}

}} // namespace programs::test
