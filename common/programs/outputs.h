// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks the output files of a command line before any work is done. */

#include "scenes/catalogue.h"

#include <string>
#include <vector>

namespace cbvh {

struct Output
{
  std::string option, path; // an empty path is not checked
};

/* Throws Error that names the option if an output would replace an input file of the model, or the file of another
 * option. Paths are compared by the files that they lead to. */
void validateOutputs(const SceneSettings& model, const std::vector<Output>& outputs);

} // namespace cbvh
