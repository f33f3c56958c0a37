# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests of common/ and of the programs in tutorials/. Included by CMakeLists.txt,
# after cbvh_test.

foreach(unit cage_tags cage_validation camera displacement height_bins height_map hit_metrics limit_surface obj_reader
        patch_walk ray_sets representation scenes silhouettes true_surface watertight)
  cbvh_test(${unit} LIBRARIES cbvh_common)
endforeach()

cbvh_test(self_shadow LIBRARIES cbvh_common scene_blocks)
target_sources(test_self_shadow PRIVATE near_side.cpp)

add_test(NAME render_cli COMMAND "${CMAKE_CURRENT_LIST_DIR}/render_cli.sh" "$<TARGET_FILE:cbvh_render>")
set_tests_properties(render_cli PROPERTIES TIMEOUT 600)
if(CBVH_SANITIZE) # OpenImageIO leaves a PNG that ends too early by longjmp, and a string behind
  set_tests_properties(render_cli PROPERTIES ENVIRONMENT "ASAN_OPTIONS=new_delete_type_mismatch=0:detect_leaks=0")
endif()
