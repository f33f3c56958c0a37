// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Products that are fused with a sum, or not, as is written: elsewhere the compiler may do it in one way here and in
 * another there. */

#include "../../common/isa.h"
#include "../../../common/simd/simd.h"

namespace embree
{
  namespace isa
  {
    namespace cbvh
    {
      /*! a product, of floats or doubles, that the compiler does not fuse with a sum */
      template<typename Scalar>
      __forceinline Scalar productOf (Scalar a, Scalar b)
      {
        Scalar p = a*b;
#if defined(__GNUC__) && defined(__SSE2__)
        asm("" : "+x"(p));
#endif
        return p;
      }
      __forceinline float product (float a, float b) { return productOf(a,b); }
      __forceinline double product (double a, double b) { return productOf(a,b); }

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

      /*! a b + c, and c - a b, fused where the instruction set can. Embree's madd of floats clears the rest of a vector first. */
      __forceinline float fused (float a, float b, float c)
      {
#if defined(__FMA__)
        return __builtin_fmaf(a,b,c);
#else
        return product(a,b) + c;
#endif
      }
      __forceinline float fusedNegative (float a, float b, float c) { return fused(-a,b,c); }

      /*! the same of vectors */
      template<typename Vector>
      __forceinline Vector fused (const Vector& a, const Vector& b, const Vector& c) { return madd(a,b,c); }
      template<typename Vector>
      __forceinline Vector fusedNegative (const Vector& a, const Vector& b, const Vector& c) { return nmadd(a,b,c); }
    }
  }
}
