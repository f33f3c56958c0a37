// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How far the sides of seams are apart before their mean closes the surface. */

#include <atomic>
#include <cstdint>
#include <cstring>

namespace programs {

struct SeamGap {
  float distance = 0; // in units of the cage
  float quads = 0;    // the largest ratio of a distance to the length of a quad there
  unsigned face = 0;  // at this ratio
};

/* The largest gaps. They do not depend on the order of the calls. Thread-safe. */
class SeamGaps {
public:
  /* `spacing` is the length of a quad at the seam. */
  void add(float distance, float spacing, unsigned face) {
    if (!(distance > 0.0f)) return;
    raise(largest, pack(distance, 0));
    raise(largestInQuads, pack(distance / spacing, ~face));
  }

  SeamGap maximum() const {
    const uint64_t inQuads = largestInQuads;
    return {value(largest), value(inQuads), inQuads ? ~unsigned(inQuads) : 0};
  }

private:
  /* Floats of at least 0 have the order of their bits. */
  static uint64_t pack(float value, unsigned rest) {
    uint32_t bits;
    std::memcpy(&bits, &value, sizeof(bits));
    return uint64_t(bits) << 32 | rest;
  }

  static float value(uint64_t packed) {
    const uint32_t bits = uint32_t(packed >> 32);
    float value;
    std::memcpy(&value, &bits, sizeof(value));
    return value;
  }

  static void raise(std::atomic<uint64_t>& maximum, uint64_t value) {
    uint64_t before = maximum.load(std::memory_order_relaxed);
    while (before < value && !maximum.compare_exchange_weak(before, value, std::memory_order_relaxed));
  }

  std::atomic<uint64_t> largest{0}, largestInQuads{0};
};

} // namespace programs
