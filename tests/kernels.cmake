# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests of kernels/cbvh. Included by CMakeLists.txt, after cbvh_test.

# The codec by itself: headers only.
foreach(unit node_codec leaf_codec frame)
  cbvh_test(${unit})
endforeach()
cbvh_test(block_format DEFINITIONS "FORMAT_MD=\"${CMAKE_SOURCE_DIR}/kernels/cbvh/FORMAT.md\"")

# What the built library holds and traces. scene_blocks.cpp reads the library's
# structures: it needs the library's definitions.
get_directory_property(embree_definitions DIRECTORY "${CMAKE_BINARY_DIR}/upstream" COMPILE_DEFINITIONS)
add_library(scene_blocks STATIC scene_blocks.cpp)
target_include_directories(scene_blocks PRIVATE "${CMAKE_BINARY_DIR}/upstream" INTERFACE "${CMAKE_CURRENT_SOURCE_DIR}")
target_compile_definitions(scene_blocks PRIVATE ${embree_definitions})
target_compile_options(scene_blocks PRIVATE -fno-strict-aliasing)
target_link_libraries(scene_blocks PUBLIC embree tbb)

# The traversal's decoders.
include(simd_decoding.cmake)

# The traversal on random bytes.
if(NOT CBVH_SANITIZE MATCHES "thread")
  include(fuzz/fuzz.cmake)
endif()

# Through the API, against GRID and against the scalar reference: hard cases ISA by ISA.
cbvh_test(hard_cases
  SOURCES hard_rays.cpp hard_blocks.cpp hard_cages.cpp hard_rates.cpp hard_displacement.cpp
          random_blocks.cpp random_sheets.cpp reference_check.cpp grid_agreement.cpp
  LIBRARIES scene_blocks DEFINITIONS "TEST_ISAS=${isas}" RESULTS "${CMAKE_CURRENT_BINARY_DIR}/hard_cases")
cbvh_test(surfaces SOURCES surfaces.cpp grid_agreement.cpp LIBRARIES scene_blocks)
cbvh_test(invalid_vertices RESULTS "${CMAKE_CURRENT_BINARY_DIR}/hard_cases")
cbvh_test(resampled_faces LIBRARIES scene_blocks)
foreach(unit mixed_rates scene_features hard_surfaces compression_api threads)
  cbvh_test(${unit})
endforeach()
