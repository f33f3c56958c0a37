// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* For programs to refuse builds that would not fit into memory. */

#include "building/representation.h"
#include "surface/model.h"

#include <cstddef>
#include <string>

namespace programs {

struct BuildSize {
  BuildSize(size_t quads, size_t timeSteps = 1) : quads(quads), timeSteps(timeSteps) {}
  BuildSize(const Model& model, int level) : quads(model.layout(level).numQuads()), timeSteps(1 + model.poses.size()) {}

  size_t quads, timeSteps;
};

/* Upper estimate of the bytes at the peak of the build. */
size_t estimatedPeakBytes(RepresentationKind kind, const BuildSize& size);

/* Bytes that this process can still allocate: the least of the machine and its control groups; SIZE_MAX if unknown.
 * `root` is the folder of proc and sys. */
size_t availableMemory(const std::string& root = "");

/* Bytes of this process in large pages (transparent huge pages); 0 on systems that do not tell. */
size_t bytesInLargePages();

} // namespace programs
