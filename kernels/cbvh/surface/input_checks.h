// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Checks of the application's buffers that Embree does not make. Functions whose names begin with "check" throw
 * rtcore_error, naming the first invalid value. */

#include "../base/number_text.h"
#include "../embree/scene.h"
#include <string>
#include <vector>

namespace embree {
/*! Throws if a time step has fewer vertices than the first, or several steps have an empty time range. */
template<typename Mesh>
void checkTimeSteps(const Mesh* mesh) {
  auto verticesAt = [&](size_t t) { return mesh->vertices[t] ? mesh->vertices[t].size() : size_t(0); };
  for (size_t t = 1; t < mesh->numTimeSteps; t++)
    if (verticesAt(t) < verticesAt(0))
      throw_RTCError(RTC_ERROR_INVALID_OPERATION, "time step " + std::to_string(t) + " has " +
                                                      std::to_string(verticesAt(t)) +
                                                      " vertices: expected at least as many as the first time step, " +
                                                      std::to_string(verticesAt(0)));
  if (mesh->numTimeSteps > 1 && !(mesh->time_range.lower < mesh->time_range.upper))
    throw_RTCError(RTC_ERROR_INVALID_ARGUMENT, "invalid time range " + numberText(mesh->time_range.lower) + " to " +
                                                   numberText(mesh->time_range.upper) +
                                                   ": expected a start before the end");
}

/*! Throws if a cage's buffers are shorter than its faces and creases require. */
void checkSizes(const SubdivMesh* mesh);

/*! Throws if a face refers to missing indices or vertices. Also checks time steps and sizes. */
void checkIndices(const SubdivMesh* mesh);

/*! Returns a sentence for each kind of value that has no effect, or none that the application can mean: creases
 *  between vertices that share no edge, and weights and levels that are not numbers. Requires checkIndices(). */
std::vector<std::string> describeIgnoredInput(const SubdivMesh* mesh);

/*! For uncompressed grids. Throws if a side has more vertices than Embree's kernel counts in 15 bits. */
void checkSides(const GridMesh* mesh);

/*! Throws if all rows of a large grid are the same vertices: there could be billions of quads without area. */
void checkStrides(const GridMesh* mesh);
} // namespace embree
