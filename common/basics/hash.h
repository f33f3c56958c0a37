// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace programs {

struct ArrayHash {
  template<size_t N>
  size_t operator()(const std::array<uint32_t, N>& words) const {
    uint64_t h = 0;
    for (uint32_t x : words) h = (h ^ x) * 0x9E3779B97F4A7C15ull, h ^= h >> 29;
    return size_t(h);
  }
};

/* FNV-1a. To continue, pass the hash of the preceding bytes. */
constexpr uint64_t emptyHash = 14695981039346656037ull;
inline uint64_t hashOfBytes(const void* data, size_t bytes, uint64_t hash = emptyHash) {
  for (size_t i = 0; i < bytes; i++) hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 1099511628211ull;
  return hash;
}

} // namespace programs
