# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# simd_decoding.cpp once for every ISA, whichever the library is built for: a program each, as
# inline functions of two ISAs in one program would be merged. Included by kernels.cmake, which
# sets embree_definitions.

# The tables, as in the library, and the check of the machine are code for every machine.
add_library(simd_decoding_common OBJECT isa_check.cpp
  "${CMAKE_BINARY_DIR}/upstream/kernels/cbvh/node_tables.cpp" "${CMAKE_BINARY_DIR}/upstream/common/simd/sse.cpp")
target_include_directories(simd_decoding_common PRIVATE "${CMAKE_BINARY_DIR}/upstream")

foreach(isa SSE2:SSE2 SSE42:SSE4.2 AVX:AVX AVX2:AVX2 AVX512:AVX512)
  string(REPLACE ":" ";" isa "${isa}")
  list(POP_FRONT isa option name)
  get_directory_property(flags DIRECTORY "${CMAKE_BINARY_DIR}/upstream" DEFINITION FLAGS_${option})
  separate_arguments(flags)
  string(TOLOWER "simd_decoding_${option}" unit)
  add_executable(test_${unit} simd_decoding.cpp $<TARGET_OBJECTS:simd_decoding_common>)
  target_include_directories(test_${unit} PRIVATE "${CMAKE_BINARY_DIR}/upstream")
  target_compile_definitions(test_${unit} PRIVATE ${embree_definitions} "TEST_ISA=\"${name}\"")
  target_compile_options(test_${unit} PRIVATE -fno-strict-aliasing ${flags})
  target_link_libraries(test_${unit} PRIVATE tbb GTest::gtest_main)
  # Not discovered: on a machine without the ISA the program only says so.
  add_test(NAME ${unit} COMMAND test_${unit})
  set_tests_properties(${unit} PROPERTIES TIMEOUT 600 SKIP_RETURN_CODE 77)
endforeach()
