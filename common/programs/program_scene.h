// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "programs/warnings.h"
#include "scenes/catalogue.h"

namespace programs {

/* Prints warnings on stderr. */
inline Model loadProgramScene(const std::string& program, const SceneSettings& settings) {
  std::string warnings;
  Model model = loadScene(settings, warnings);
  printWarnings(program, warnings);
  return model;
}

} // namespace programs
