// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* For programs to refuse builds that would not fit into memory. */

#include "building/representation.h"
#include "surface/model.h"

#include <cstddef>

namespace cbvh {

struct BuildSize
{
  BuildSize(size_t quads, size_t timeSteps = 1) : quads(quads), timeSteps(timeSteps) {}
  BuildSize(const Model& model, int level) : quads(model.layout(level).numQuads()), timeSteps(1 + model.poses.size()) {}

  size_t quads, timeSteps;
};

/* Upper estimate of the bytes at the peak of the build. */
size_t estimatedPeakBytes(RepresentationKind kind, const BuildSize& size);

/* Bytes that this process can still allocate: the machine's or its control group's, whichever is less; SIZE_MAX if
 * neither is known. */
size_t availableMemory();

} // namespace cbvh
