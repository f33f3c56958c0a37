// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Hashes of keys of a few words, for containers. */

#include <array>
#include <cstddef>
#include <cstdint>

namespace cbvh {

struct HashOfWords
{
  template<size_t N>
  size_t operator()(const std::array<uint32_t, N>& words) const
  {
    uint64_t h = 0;
    for (uint32_t x : words)
      h = (h ^ x) * 0x9E3779B97F4A7C15ull, h ^= h >> 29;
    return size_t(h);
  }
};

} // namespace cbvh
