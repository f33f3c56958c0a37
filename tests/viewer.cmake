# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests of cbvh_viewer. Included by CMakeLists.txt.

find_package(Python3 REQUIRED COMPONENTS Interpreter)

add_test(NAME viewer_cli COMMAND "${CMAKE_CURRENT_LIST_DIR}/viewer_cli.sh" "$<TARGET_FILE:cbvh_viewer>")
# On a display of its own.
add_test(NAME viewer_window COMMAND "${Python3_EXECUTABLE}" "${CMAKE_CURRENT_LIST_DIR}/viewer_window.py"
  "$<TARGET_FILE:cbvh_viewer>")
set_tests_properties(viewer_cli viewer_window PROPERTIES TIMEOUT 600)
set_tests_properties(viewer_window PROPERTIES SKIP_RETURN_CODE 77)
