// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Memory that a build needs, and memory that is available, to refuse builds that would not fit. */

#include "building/representation.h"
#include "surface/model.h"

#include <cstddef>

namespace cbvh {

/* The size of a model at a level. */
struct BuildSize
{
  BuildSize(size_t quads, size_t timeSteps = 1) : quads(quads), timeSteps(timeSteps) {}
  BuildSize(const Model& model, int level) : quads(model.layout(level).numQuads()), timeSteps(1 + model.poses.size()) {}

  size_t quads, timeSteps;
};

/* Returns an upper estimate of the bytes that building a representation needs at its peak. */
size_t estimatedPeakBytes(RepresentationKind kind, const BuildSize& size);

/* Returns the bytes that this process can still allocate: the machine's or its control group's, whichever is less.
 * Returns SIZE_MAX if neither can be read. */
size_t availableMemory();

} // namespace cbvh
