// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vertices of a mesh by position. Exports split vertices for the sake of attributes: at sharp edges, at seams, or at
 * all edges. Positions decide how rays hit triangles, so vertices that are the same floats at all time steps are one.
 * Both zeros are the same float. */

#include "../base/unmonitored_memory.h"
#include <memory>

namespace embree
{
  class WeldedVertices
  {
  public:
    /*! Finds the vertices that are equal at all time steps. Returns null if there are none. steps: vertices at each
     *  time step, at least n each. The result is the same for any number of threads. */
    static std::shared_ptr<const WeldedVertices> find (const BufferView<Vec3fa>* steps, unsigned numSteps,
                                                       size_t n);

    /*! Lowest vertex with the same position. A number that is no vertex is returned as it is. */
    unsigned operator[] (unsigned vertex) const { return vertex < firsts.size() ? firsts[vertex] : vertex; }

    size_t bytes () const { return firsts.size()*sizeof(unsigned); }

  private:
    cbvh::UnmonitoredVector<unsigned> firsts;
  };
}
