// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compresses a model straight into a file: one copy after the other, so that memory holds one at a time. */

#include "building/built_scene.h"

#include <string>

namespace cbvh {

struct FileBuildReport
{
  size_t geometries = 0, found = 0; // found: of a build that was stopped, and not made again
  double seconds = 0;               // of the others, writing included
  size_t quads = 0;                 // likewise
  size_t peakBytes = 0;             // most that the device held
};

/* Builds and saves. What was saved when it is stopped, or the process is killed, stays beside the file with ".part" behind its name, and the next call for
 * the same model, representation and settings goes on with it. Shows progress.
 *
 * representation: compressed. Errors: throws Error, Cancelled. */
FileBuildReport buildToFile(const Model& model, const Representation& representation, const BuildSettings& settings, const std::string& path);

} // namespace cbvh
