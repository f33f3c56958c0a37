// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "options.h"

namespace programs {

struct ModelView {
  Model model;
  Camera camera;
  BuildSettings build;

  /* Throws Error. */
  explicit ModelView(const Options& options);
};

} // namespace programs
