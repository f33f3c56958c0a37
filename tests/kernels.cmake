# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests of kernels/cbvh. Included by CMakeLists.txt, after cbvh_test.

# The codec by itself: headers only.
foreach(unit node_codec leaf_codec frame)
  cbvh_test(${unit})
endforeach()
cbvh_test(block_format DEFINITIONS "FORMAT_MD=\"${CMAKE_SOURCE_DIR}/kernels/cbvh/FORMAT.md\"")
