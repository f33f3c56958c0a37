// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>

namespace programs::test {

// CBVH_RANDOM_GEOMETRIES replaces the default.
inline size_t randomRounds(size_t byDefault) {
  const char* const many = std::getenv("CBVH_RANDOM_GEOMETRIES");
  return many ? std::strtoull(many, nullptr, 10) : byDefault;
}

// Depends on CBVH_RANDOM_SEED, so that several processes can share a long run.
inline uint32_t randomSeed(uint32_t byDefault) {
  const char* const other = std::getenv("CBVH_RANDOM_SEED");
  return byDefault + (other ? uint32_t(std::strtoul(other, nullptr, 10)) * 0x9E3779B9u : 0);
}

} // namespace programs::test
