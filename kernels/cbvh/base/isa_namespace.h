// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The codec is inline code without any intrinsics, but compiled once for every ISA.
 * A namespace of its own for each keeps the linker from merging them: it would take any,
 * and an SSE machine could end up with instructions of AVX. Used as an inline
 * namespace, so nobody has to write it. */

#if defined(__AVX512F__)
#  define CBVH_ISA isa_avx512
#elif defined(__AVX2__)
#  define CBVH_ISA isa_avx2
#elif defined(__AVX__)
#  define CBVH_ISA isa_avx
#elif defined(__SSE4_2__)
#  define CBVH_ISA isa_sse42
#else
#  define CBVH_ISA isa_lowest
#endif
