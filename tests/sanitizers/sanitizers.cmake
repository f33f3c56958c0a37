# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Compiles and links everything with CBVH_SANITIZE, upstream too, but for its intersectors
# of other geometry: ours never run them, and they would take most of the time to
# compile. A report ends the program, so that its test fails.
#
# Included before upstream is added; sanitize_upstream() is called after.

if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  message(FATAL_ERROR "  CBVH_SANITIZE needs clang")
endif()

# function: upstream calls the intersectors of all accelerators through pointers of one
# type, to which DEFINE_INTERSECTOR1 and its like cast them (kernels/common/accel.h).
# vptr: tests that look into the library's classes lack their type information, it is hidden.
add_compile_options(-fsanitize=${CBVH_SANITIZE} -fno-sanitize=function,vptr -fno-sanitize-recover=all -fno-omit-frame-pointer)
# The program brings the runtime; the library, which upstream links with --no-undefined, has none.
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
  # It compares the edge rates of a patch with those that memory held before.
  set_source_files_properties("${tree}/kernels/subdiv/subdivpatch1base.cpp" TARGET_DIRECTORY embree
    PROPERTIES COMPILE_OPTIONS -fno-sanitize=float-cast-overflow)
endfunction()
