// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Welds the vertices of a mesh by position. Exporters duplicate vertices with different normals or texture coordinates.
 * Only positions determine hits, so vertices that are equal floats at all time steps count as one. Zero and minus zero
 * are equal. */

#include "../base/unmonitored_memory.h"
#include <memory>

namespace embree
{
  class WeldedVertices
  {
  public:
    /*! Welds n vertices. Returns null if no two are equal. steps: one buffer per time step, with at least n vertices.
     *  The result is independent of the number of threads. */
    static std::shared_ptr<const WeldedVertices> find (const BufferView<Vec3fa>* steps, unsigned numSteps,
                                                       size_t n);

    /*! Returns the lowest vertex with the same position. Invalid indices are returned unchanged. */
    unsigned operator[] (unsigned vertex) const { return vertex < firsts.size() ? firsts[vertex] : vertex; }

    size_t bytes () const { return firsts.size()*sizeof(unsigned); }

  private:
    cbvh::UnmonitoredVector<unsigned> firsts;
  };
}
