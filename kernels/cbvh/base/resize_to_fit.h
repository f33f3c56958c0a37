// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Embree's vectors grow to powers of two. Large vectors that are resized only once do not need the spare memory. */

#include <cstddef>

namespace embree
{
  namespace cbvh
  {
    /*! Resizes an empty vector without spare capacity. */
    template<typename Vector>
    void resizeToFit (Vector& vector, size_t size)
    {
      vector.reserve(size);
      vector.resize(size);
    }
  }
}
