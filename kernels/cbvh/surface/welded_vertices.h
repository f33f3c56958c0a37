// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a mesh by position. Exporters duplicate vertices with different attributes. Only positions determine
 * hits, so vertices that are equal floats at all time steps count as one. Both zeros are equal. */

#include "../base/unmonitored_memory.h"
#include <memory>

namespace embree
{
  class WeldedVertices
  {
  public:
    /*! Null if no vertices are equal. steps: at least n vertices per time step. The result is independent of the number
     *  of threads. */
    static std::shared_ptr<const WeldedVertices> find (const BufferView<Vec3fa>* steps, unsigned numSteps,
                                                       size_t n);

    /*! Lowest vertex with the same position. Numbers that are not vertices are returned unchanged. */
    unsigned operator[] (unsigned vertex) const { return vertex < firsts.size() ? firsts[vertex] : vertex; }

    size_t bytes () const { return firsts.size()*sizeof(unsigned); }

  private:
    cbvh::UnmonitoredVector<unsigned> firsts;
  };
}
