// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "surface/cage.h"

#include <algorithm>
#include <cstddef>

namespace programs {

struct BlockGrid {
  const PatchLayout& layout;
  int level;
  int frameLevel;

  /* Width in quads; a patch may be narrower. */
  size_t blockWidth() const { return size_t(1) << std::max(0, level - frameLevel); }
};

} // namespace programs
