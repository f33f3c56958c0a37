# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests of cbvh_viewer and of Embree's own viewers. Included by CMakeLists.txt.

find_package(Python3 REQUIRED COMPONENTS Interpreter)

add_test(NAME viewer_cli COMMAND "${CMAKE_CURRENT_LIST_DIR}/viewer_cli.sh" "$<TARGET_FILE:cbvh_viewer>")
set_tests_properties(viewer_cli PROPERTIES TIMEOUT 600)

# On a display of its own.
set(missing "")
foreach(tool Xvfb xdotool)
  find_program(VIEWER_TEST_${tool} ${tool})
  mark_as_advanced(VIEWER_TEST_${tool})
  if(NOT VIEWER_TEST_${tool})
    list(APPEND missing ${tool})
  endif()
endforeach()
if(missing)
  list(JOIN missing " and " missing)
  cbvh_skipped_test(viewer_window "no ${missing}, see scripts/packages")
else()
  add_test(NAME viewer_window COMMAND "${Python3_EXECUTABLE}" "${CMAKE_CURRENT_LIST_DIR}/viewer_window.py"
    "$<TARGET_FILE:cbvh_viewer>")
  # 77: they were there when this was configured
  set_tests_properties(viewer_window PROPERTIES TIMEOUT 600 SKIP_RETURN_CODE 77)
endif()

# Embree's own programs, and a scene in their format.
add_executable(displaced_cage displaced_cage.cpp)
target_compile_options(displaced_cage PRIVATE -Wall -Wextra)
target_link_libraries(displaced_cage PRIVATE cbvh_common)
add_test(NAME embree_tutorials COMMAND "${Python3_EXECUTABLE}" "${CMAKE_CURRENT_LIST_DIR}/embree_tutorials.py"
  "$<TARGET_FILE_DIR:viewer>" "${CMAKE_BINARY_DIR}/upstream/tutorials/models" "$<TARGET_FILE:displaced_cage>")
set_tests_properties(embree_tutorials PROPERTIES TIMEOUT 600)
