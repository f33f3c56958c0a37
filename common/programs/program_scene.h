// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Loads the scene that a program's options name. */

#include "programs/warnings.h"
#include "scenes/catalogue.h"

namespace cbvh {

/* Calls loadScene and prints its warnings on stderr, prefixed with the program's name. */
inline Model loadProgramScene(const std::string& program, const SceneSettings& settings)
{
  std::string warnings;
  Model model = loadScene(settings, warnings);
  printWarnings(program, warnings);
  return model;
}

} // namespace cbvh
