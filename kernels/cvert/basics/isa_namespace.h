// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Inline code is compiled once for every instruction set of a program. Each has its own namespace; without, the linker would keep one
 * copy of a function, which might contain instructions of AVX, and a machine without AVX would run it. It is an inline namespace, so that
 * nobody has to write it. */

#if defined(CVERT_PORTABLE)
#  define CVERT_ISA isa_portable
#elif defined(__AVX512F__)
#  define CVERT_ISA isa_avx512
#elif defined(__AVX2__)
#  define CVERT_ISA isa_avx2
#elif defined(__AVX__)
#  define CVERT_ISA isa_avx
#elif defined(__SSE4_2__)
#  define CVERT_ISA isa_sse42
#else
#  define CVERT_ISA isa_lowest
#endif
