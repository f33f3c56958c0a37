// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Renders files that --save wrote. */

#include "model_view.h"

namespace cbvh {

/* Opens options.loadPath, writes the picture, and prints the contents of the file and times. Throws Error. */
void renderSaved(const Options& options);

/* Builds a model of many copies into the file of --save, copy by copy, and renders the file. Throws Error. */
void saveAndRender(const Options& options, const ModelView& view);

} // namespace cbvh
