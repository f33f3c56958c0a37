// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "scenes/catalogue.h"

#include <string>
#include <vector>

namespace programs {

struct Output {
  std::string option, path;
};

/* Records the model's files as inputs. Throws Error with the option if an output would replace an input or another
 * output. Compares the files to which paths lead. */
void validateOutputs(const SceneSettings& model, const std::vector<Output>& outputs);

/* Throws Error with the option if the folder of an output does not exist. */
void requireFolders(const std::vector<Output>& outputs);

/* The same for every output that cannot be written. To be called before long work. */
void requireWritable(const std::vector<Output>& outputs);

} // namespace programs
