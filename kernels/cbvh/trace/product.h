// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Products that stay products: elsewhere the compiler may fuse them with a sum, here in one way and there in another. */

#include "../../common/isa.h"
#include "../../../common/simd/simd.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! a product that the compiler does not fuse with a sum */
      __forceinline float product (float a, float b)
      {
        float p = a*b;
#if defined(__GNUC__) && defined(__SSE2__)
        asm("" : "+x"(p));
#endif
        return p;
      }

      /*! the same of vectors */
      template<typename Vector>
      __forceinline Vector product (const Vector& a, const Vector& b)
      {
        Vector p = a*b;
#if defined(__GNUC__) && defined(__AVX512F__)
        asm("" : "+v"(p.v));
#elif defined(__GNUC__) && defined(__SSE2__)
        asm("" : "+x"(p.v));
#endif
        return p;
      }
    }
  }
}
