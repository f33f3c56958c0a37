// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

namespace programs {

struct ImageSize {
  int width = 1024, height = 1024;
};

} // namespace programs
