# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# What a build for ARM64 has in place of x86's instruction sets, which are off
# even where a preset names them: NEON, in upstream's files for SSE2 and under
# that name.

# Upstream detects NEON, but only after it has chosen x86's compiler flags.
set(EMBREE_ARM ON)
set(EMBREE_ISA_NEON ON CACHE BOOL "Enables NEON ISA.")
set(EMBREE_ISA_NEON2X OFF CACHE BOOL "Enables NEON ISA double pumped.")
set(EMBREE_ISA_SSE2 ON)
foreach(isa SSE42 AVX AVX2 AVX512)
  set(EMBREE_ISA_${isa} OFF)
endforeach()

# GCC fuses products and sums by default. Blocks have the same bytes as on
# x86-64 because builders, there for SSE2 and AVX, cannot fuse anything.
add_compile_options("$<$<COMPILE_LANGUAGE:C,CXX>:-ffp-contract=off>")
# Programs that include upstream's headers need its kind of char.
add_compile_options("$<$<COMPILE_LANGUAGE:C,CXX>:-fsigned-char>")
# Upstream's SSE for NEON has one type for all integers; clang converts it unasked.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  add_compile_options("$<$<COMPILE_LANGUAGE:CXX>:-flax-vector-conversions>")
endif()
