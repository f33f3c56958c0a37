// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Welds the vertices of a mesh by position. Exporters duplicate vertices with different normals or texture coordinates,
 * which do not affect hits. Vertices that are equal floats at all time steps count as one; zero equals minus zero. */

#include "../base/unmonitored_memory.h"
#include <memory>

namespace embree {
class WeldedVertices {
public:
  /*! Welds n vertices, independently of the number of threads. Returns null if no two are equal, or n is
   *  2^32-1 or more. steps: one buffer per time step, with at least n vertices. */
  static std::shared_ptr<const WeldedVertices> find(const BufferView<Vec3fa>* steps, unsigned numSteps, size_t n);

  /*! Returns the lowest vertex with the same position. Invalid indices are returned unchanged. */
  unsigned operator[](unsigned vertex) const { return vertex < firsts.size() ? firsts[vertex] : vertex; }

  size_t bytes() const { return firsts.size() * sizeof(unsigned); }

private:
  cbvh::UnmonitoredVector<unsigned> firsts;
};
} // namespace embree
