// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's vectors grow to a power of two. A vector that is large and is sized once does not need the rest. */

#include <cstddef>

namespace embree
{
  namespace cbvh
  {
    /*! Resizes an empty vector without room for more. */
    template<typename Vector>
    void resizeToFit (Vector& vector, size_t size)
    {
      vector.reserve(size);
      vector.resize(size);
    }
  }
}
