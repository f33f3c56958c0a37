// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The files that a command line names for output, looked at before any work is done. */

#include "scenes/catalogue.h"

#include <string>
#include <vector>

namespace cbvh {

struct Output
{
  std::string option, path; // an empty path: not asked for
};

/* Throws Error, which names the option, for an output that would replace a file that the model is read from, or the
 * file of another option. Paths are the same if they lead to the same file. */
void validateOutputs(const SceneSettings& model, const std::vector<Output>& outputs);

} // namespace cbvh
