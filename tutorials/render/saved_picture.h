// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A picture of what --save wrote. */

#include "model_view.h"

namespace cbvh {

/* Opens options.loadPath, writes the picture, and says on standard output what there is and how long it took. Throws Error, Cancelled. */
void renderSaved(const Options& options);

/* Builds a model of many copies into the file of --save, copy by copy, and makes its picture from there. Throws Error, Cancelled. */
void saveAndRender(const Options& options, const ModelView& view);

} // namespace cbvh
