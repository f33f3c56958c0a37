// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compresses a model directly into a file, one copy after the other, so that memory holds only one at a time. */

#include "building/built_scene.h"

#include <string>

namespace cbvh {

struct FileBuildReport
{
  size_t geometries = 0, found = 0; // found: in the file of an interrupted build
  double seconds = 0;               // for the other geometries, including writing
  size_t quads = 0;                 // of the other geometries
  size_t peakBytes = 0;             // the most that the device held
};

/* Builds a model and saves it. `representation` must be compressed. Shows progress. If the build is cancelled or the
 * process is killed, the geometries so far remain in a file next to `path` with ".part" appended, and the next call
 * with the same model, representation and settings resumes it. Throws Error, Cancelled. */
FileBuildReport buildToFile(const Model& model, const Representation& representation, const BuildSettings& settings,
                            const std::string& path);

} // namespace cbvh
