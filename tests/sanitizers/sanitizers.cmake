# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Compiles and links everything with CBVH_SANITIZE, including upstream, except for upstream's intersectors of other
# geometry: our tests never run them, and compiling them would take most of the time. A report ends the program, so
# that its test fails.
#
# Include this file before upstream is added, and call sanitize_upstream() afterwards.

if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  message(FATAL_ERROR "  CBVH_SANITIZE requires clang")
endif()

# function: upstream calls the intersectors of all accelerators through pointers of one type, to which
# DEFINE_INTERSECTOR1 and similar macros cast them (kernels/common/accel.h). vptr: the type information of the
# library's classes is hidden from tests that access them.
add_compile_options(-fsanitize=${CBVH_SANITIZE} -fno-sanitize=function,vptr -fno-sanitize-recover=all
  -fno-omit-frame-pointer)
# The program contains the runtime; the library, which upstream links with --no-undefined, does not.
add_link_options(-fsanitize=${CBVH_SANITIZE} -Wl,-z,undefs)

function(sanitize_upstream tree)
  foreach(target embree embree_sse42 embree_avx embree_avx2 embree_avx512)
    if(TARGET ${target})
      get_target_property(sources ${target} SOURCES)
      list(FILTER sources INCLUDE REGEX "bvh/bvh_intersector|geometry/curve_intersector")
      foreach(source IN LISTS sources)
        get_filename_component(source "${source}" ABSOLUTE BASE_DIR "${tree}/kernels")
        set_source_files_properties("${source}" TARGET_DIRECTORY ${target} PROPERTIES COMPILE_OPTIONS -fno-sanitize=all)
      endforeach()
    endif()
  endforeach()
  # Upstream compares the edge rates of a patch with uninitialized memory.
  set_source_files_properties("${tree}/kernels/subdiv/subdivpatch1base.cpp" TARGET_DIRECTORY embree
    PROPERTIES COMPILE_OPTIONS -fno-sanitize=float-cast-overflow)
endfunction()
