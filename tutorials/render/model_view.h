// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What the options say: a model, from where it is looked at, and how finely it is built for that. */

#include "options.h"

namespace cbvh {

struct ModelView
{
  Model model;
  Camera camera;
  BuildSettings build;

  /* Throws Error, Cancelled. */
  explicit ModelView(const Options& options);
};

} // namespace cbvh
