// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* For tests that pin bytes: input that is the same on every machine, and checksums. */

#include <cstddef>
#include <cstdint>

namespace programs::test {

// Knuth's MMIX generator; returns its upper bits.
class Integers {
public:
  explicit Integers(uint64_t seed) : state(seed) {}
  int within(int magnitude) // [-magnitude, magnitude]
  {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return int((state >> 33) % uint64_t(2 * magnitude + 1)) - magnitude;
  }

private:
  uint64_t state;
};

// 64-bit FNV-1a.
inline uint64_t checksum(const void* data, size_t bytes) {
  uint64_t value = 0xcbf29ce484222325u;
  for (size_t i = 0; i < bytes; i++) value = (value ^ ((const uint8_t*)data)[i]) * 0x100000001b3u;
  return value;
}

} // namespace programs::test
