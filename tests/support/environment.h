// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdlib>

namespace programs::test {

class Environment {
public:
  explicit Environment(const char* value) { setenv("EMBREE_CBVH", value, 1); }
  ~Environment() { unsetenv("EMBREE_CBVH"); }
};

} // namespace programs::test
