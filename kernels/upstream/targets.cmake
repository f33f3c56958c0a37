# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Changes of upstream's targets that need no patch: what they compile, with which options, and how quickly.

set(UPSTREAM_ISA_TARGETS "")
foreach(isa embree embree_sse42 embree_avx embree_avx2 embree_avx512)
  if(TARGET ${isa})
    list(APPEND UPSTREAM_ISA_TARGETS ${isa})
  endif()
endforeach()

# Upstream compiles its code for curves and points, which is among its largest, even if both are disabled.
if(NOT EMBREE_GEOMETRY_CURVE AND NOT EMBREE_GEOMETRY_POINT)
  string(JOIN "|" unused curve_intersector_virtual "/scene_(curves|points|line_segments)" /bvh_builder_hair
    "/(bezier|bspline|catmullrom)_curve")
  foreach(isa IN LISTS UPSTREAM_ISA_TARGETS)
    get_target_property(sources ${isa} SOURCES)
    list(FILTER sources EXCLUDE REGEX "${unused}")
    set_target_properties(${isa} PROPERTIES SOURCES "${sources}")
  endforeach()
endif()
# Upstream's list for AVX has files that higher ISAs need, too.
if(EMBREE_ISA_SSE2 AND NOT EMBREE_ISA_AVX)
  foreach(isa avx2 avx512)
    if(TARGET embree_${isa})
      set(missing bvh/bvh bvh/bvh_statistics geometry/primitive8)
      if(isa STREQUAL avx512)
        list(APPEND missing bvh/bvh_builder_morton bvh/bvh_rotate builders/primrefgen)
      endif()
      list(TRANSFORM missing REPLACE "(.+)" "${upstream}/kernels/\\1.cpp")
      target_sources(embree_${isa} PRIVATE ${missing})
    endif()
  endforeach()
endif()
# Builders that cbvh_render does not use must be linked, and take long to optimize.
if(CBVH_PICTURES_ONLY)
  get_target_property(sources embree SOURCES)
  string(JOIN "|" unused "bvh_builder_(twolevel|sah_mb|sah_spatial|morton)" rtcore_builder
    "bvh_(collider|refit|rotate)" instance_intersector motion_derivative)
  list(FILTER sources INCLUDE REGEX "${unused}")
  list(TRANSFORM sources PREPEND "${upstream}/kernels/")
  set_source_files_properties(${sources} TARGET_DIRECTORY embree PROPERTIES COMPILE_OPTIONS "-O1")
  # From GCC 13 on, a precompiled header that was compiled with -O3 is invalid for these files.
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_GREATER_EQUAL 13)
    set_source_files_properties(${sources} TARGET_DIRECTORY embree PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
  endif()
endif()
# Parsing scene.h takes 4 s of the compile time of each of these files. GCC forgets upstream's pragmas about warnings in
# precompiled headers.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND NOT CBVH_SANITIZE)
  foreach(isa IN LISTS UPSTREAM_ISA_TARGETS)
    target_precompile_headers(${isa} PRIVATE "${upstream}/kernels/common/scene.h")
    target_compile_options(${isa} PRIVATE -fno-canonical-system-headers -fpch-preprocess
      -Wno-maybe-uninitialized -Wno-misleading-indentation -Wno-parentheses -Wno-sign-compare)
    # GCC recognizes a precompiled file by its content, comments and macros included. Keys made from preprocessed text
    # do not contain these, so ccache would return the precompiled header of another version. base_dir follows links:
    # sources of embree, which are links, would not find upstream's headers.
    if(CBVH_CCACHE)
      set(base_dir "${CMAKE_SOURCE_DIR}")
      if(isa STREQUAL embree)
        set(base_dir "")
      endif()
      set_target_properties(${isa} PROPERTIES CXX_COMPILER_LAUNCHER
        "${CBVH_CCACHE};CCACHE_BASEDIR=${base_dir};CCACHE_DEPEND=1;${CCACHE_PROGRAM}")
    endif()
  endforeach()
  get_target_property(sources embree SOURCES)
  list(FILTER sources INCLUDE REGEX "/?(rtcore|rtcore_.*|flat_scene|embree)\\.(cpp|rc)$")
  list(TRANSFORM sources PREPEND "${upstream}/kernels/")
  set_source_files_properties(${sources} TARGET_DIRECTORY embree PROPERTIES SKIP_PRECOMPILE_HEADERS ON)
endif()
# GCC 12 warns of its own intrinsics for AVX-512 (its bug 105593). If AVX-512 is the only instruction set, the target
# embree contains most of its code.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  if(TARGET embree_avx512)
    target_compile_options(embree_avx512 PRIVATE -Wno-uninitialized)
  endif()
  if(EMBREE_ISA_AVX512 AND NOT EMBREE_ISA_SSE2)
    target_compile_options(embree PRIVATE -Wno-uninitialized)
  endif()
endif()
# Encoders store the same bytes in builds without SSE2, which compile them with fused multiply-adds enabled.
if(NOT EMBREE_ISA_SSE2 AND NOT EMBREE_ARM)
  target_compile_options(embree PRIVATE -ffp-contract=off)
endif()
