// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's vectors grow to a power of two; what is large and made once does not have to. */

#include <cstddef>

namespace embree
{
  namespace cbvh
  {
    /*! to that size, without room for more */
    template<typename Vector>
    void resizeExactly (Vector& vector, size_t size)
    {
      vector.reserve(size);
      vector.resize(size);
    }
  }
}
