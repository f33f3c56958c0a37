// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "model_view.h"

namespace programs {

/* Renders the file options.loadPath into the output folder, and prints its size, its number of quads and times. Also
 * writes the files of --exr and --json, and measures --speed. Throws Error. */
void renderSavedScene(const Options& options);

/* Compresses a model copy by copy into the file options.savePath, with the first representation of the options, and
 * renders the file as renderSavedScene does. The representation must be compressed. Throws Error. */
void saveAndRender(const Options& options, const ModelView& view);

} // namespace programs
