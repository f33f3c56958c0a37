// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compresses a model directly into a file, one copy at a time, to save memory. */

#include "building/built_scene.h"

#include <string>

namespace programs {

struct FileBuildReport {
  size_t geometries = 0, found = 0; // found: in the file of an interrupted build
  double seconds = 0;               // without these
  size_t quads = 0;                 // without these
  size_t peakBytes = 0;             // maximum that the device held
  SeamGap seams;                    // closed by the displacement, without these
};

/* `representation` must be compressed. Shows progress. After a cancellation or a crash, finished geometries remain
 * in `path` with ".part" appended; the next call with the same model, representation and settings resumes there.
 * Throws Error. */
FileBuildReport buildToFile(const Model& model, const Representation& representation, const BuildSettings& settings,
                            const std::string& path);

/* Hash of all that the stored surfaces depend on, with samples of the displacement. Only an interrupted build of the
 * same key is resumed. */
unsigned long long inputKey(const Model& model, const Representation& representation, const BuildSettings& settings);

} // namespace programs
