# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Settings of a build for ARM64. Upstream compiles its SSE2 files for NEON, under the name SSE2. The other ISAs are
# disabled even if a preset enables them.

# set here because upstream detects NEON only after it has chosen compiler flags for x86
set(EMBREE_ARM ON)
set(EMBREE_ISA_NEON ON CACHE BOOL "Enables NEON ISA.")
set(EMBREE_ISA_NEON2X OFF CACHE BOOL "Enables NEON ISA double pumped.")
set(EMBREE_ISA_SSE2 ON)
foreach(isa SSE42 AVX AVX2 AVX512)
  set(EMBREE_ISA_${isa} OFF)
endforeach()

# Compilers fuse multiply-adds by default. Without fusing, blocks have the same bytes as on x86-64, where builders are
# compiled for SSE2 and AVX.
add_compile_options("$<$<COMPILE_LANGUAGE:C,CXX>:-ffp-contract=off>")
# Upstream's headers expect signed chars.
add_compile_options("$<$<COMPILE_LANGUAGE:C,CXX>:-fsigned-char>")
# Upstream's SSE for NEON has one type for all integer vectors. Clang converts it without a flag.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options("$<$<COMPILE_LANGUAGE:CXX>:-flax-vector-conversions>")
endif()
