// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Vectors of four doubles, in place of Embree's vdouble4, which requires AVX. Each lane has the result of scalar code.
 * double4_avx.h documents the functions. */

#if defined(__aarch64__) // tested first, because Embree defines macros of SSE2 and AVX on ARM64, too
#include "double4_neon.h"
#elif defined(__AVX__)
#include "double4_avx.h"
#else
#include "double4_sse.h"
#endif

namespace cvert { inline namespace CVERT_ISA {
/* The functions of language.h for templates on Wide. Operands are swapped because min(b,a) is a < b ? a : b in each
 * lane, as in minimum(a,b) of scalars, also for NaN and zeros. */
inline Double4 minimum(Double4 a, Double4 b) { return min(b, a); }
inline Double4 maximum(Double4 a, Double4 b) { return max(b, a); }
inline Double4 magnitude(Double4 a) { return abs(a); }
inline Double4 nonZero(Double4 a) { return select(abs(a) <= 0.0, std::numeric_limits<double>::quiet_NaN(), a); }
inline Double4 product(Double4 a, Double4 b) {
  Double4 p = a * b;
#if defined(__GNUC__) && defined(__AVX__) && defined(__x86_64__)
  asm("" : "+x"(p.v)); // prevents fusing, see unfused() in language.h
#endif                 // ARM64: -ffp-contract=off, kernels/upstream/arm64.cmake
  return p;
}
}} // namespace cvert::CVERT_ISA
