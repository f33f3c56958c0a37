// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The scene of a program's options. */

#include "programs/warnings.h"
#include "scenes/catalogue.h"

namespace cbvh {

/* As loadScene, with its warnings on stderr after the program's name. */
inline Model loadSceneOf(const std::string& program, const SceneSettings& settings)
{
  std::string warnings;
  Model model = loadScene(settings, warnings);
  printWarnings(program, warnings);
  return model;
}

} // namespace cbvh
