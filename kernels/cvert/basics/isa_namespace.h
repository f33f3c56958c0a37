// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Inline code is compiled once per instruction set, each time in its own inline namespace. In a common namespace the
 * linker would keep one copy of each function, which might use AVX on machines without it. */

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
