// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vectors of four doubles, which Embree has only for AVX. Operations round as scalar ones do. */

#if defined(__aarch64__) // first: Embree defines SSE2 and AVX there, too
#include "double4_neon.h"
#elif defined(__AVX__)
#include "double4_avx.h"
#else
#include "double4_sse.h"
#endif

namespace cvert { inline namespace CVERT_ISA
{
  inline Double4 lesser(Double4 a, Double4 b) { return min(b,a); }
  inline Double4 greater(Double4 a, Double4 b) { return max(b,a); }
  inline Double4 magnitude(Double4 a) { return abs(a); }
  inline Double4 product(Double4 a, Double4 b)
  {
    Double4 p = a*b;
#if defined(__GNUC__) && defined(__AVX__) && defined(__x86_64__)
    asm("" : "+x"(p.v));
#endif
    return p;
  }
}}
