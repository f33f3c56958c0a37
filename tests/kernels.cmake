# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests of kernels/cbvh. Included by CMakeLists.txt, after cbvh_test.

# The codec by itself: headers only.
foreach(unit node_codec leaf_codec frame)
  cbvh_test(${unit})
endforeach()
cbvh_test(block_format DEFINITIONS "FORMAT_MD=\"${CMAKE_SOURCE_DIR}/kernels/cbvh/FORMAT.md\"")

# What the built library traces, ISA by ISA, against the reference on its own blocks.
# scene_blocks.cpp reads the library's structures: it needs the library's definitions.
get_directory_property(embree_definitions DIRECTORY "${CMAKE_BINARY_DIR}/upstream" COMPILE_DEFINITIONS)
add_library(scene_blocks STATIC scene_blocks.cpp)
target_include_directories(scene_blocks PRIVATE "${CMAKE_BINARY_DIR}/upstream" INTERFACE "${CMAKE_CURRENT_SOURCE_DIR}")
target_compile_definitions(scene_blocks PRIVATE ${embree_definitions})
target_compile_options(scene_blocks PRIVATE -fno-strict-aliasing)
target_link_libraries(scene_blocks PUBLIC embree tbb)
cbvh_test(simd_reference LIBRARIES scene_blocks DEFINITIONS "TEST_ISAS=${isas}")

# The traversal on random bytes.
include(fuzz/fuzz.cmake)

# Through the API, against GRID.
cbvh_test(surfaces LIBRARIES scene_blocks)
foreach(unit watertight mixed_rates resampled_faces scene_features invalid_vertices hard_surfaces compression_api threads)
  cbvh_test(${unit})
endforeach()
