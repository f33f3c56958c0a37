// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "model_view.h"

namespace cbvh {

/* Writes the picture of options.loadPath, and prints the file's contents and times. Throws Error. */
void renderSaved(const Options& options);

/* Builds a model of many copies into the file of --save, and renders the file. Throws Error. */
void saveAndRender(const Options& options, const ModelView& view);

} // namespace cbvh
