// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdlib>

namespace cbvh::test {

// How many random geometries a test makes: more if the environment says so.
inline size_t randomRounds(size_t byDefault)
{
  const char* const many = std::getenv("CBVH_RANDOM_GEOMETRIES");
  return many ? std::strtoull(many, nullptr, 10) : byDefault;
}

} // namespace cbvh::test
