// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a build takes of memory, and what there is of it: asked before something is built
 * that would not fit. */

#include "building/representation.h"
#include "surface/model.h"

#include <cstddef>

namespace cbvh {

/* What there is of a model at a level. */
struct BuildSize
{
  BuildSize(size_t quads, size_t timeSteps = 1) : quads(quads), timeSteps(timeSteps) {}
  BuildSize(const Model& model, int level) : quads(model.layout(level).numQuads()), timeSteps(1 + model.poses.size()) {}

  size_t quads, timeSteps;
};

/* Bytes that building a representation needs at its peak, an upper estimate. */
size_t estimatedPeakBytes(RepresentationKind kind, const BuildSize& size);

/* Bytes that this process can still get: the machine's or its control group's,
 * whichever is less. SIZE_MAX when neither can be read. */
size_t availableMemory();

} // namespace cbvh
