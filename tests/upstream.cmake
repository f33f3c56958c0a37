# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests of the library as a drop-in, and of what makes it out of upstream's source.
# Included by CMakeLists.txt, after cbvh_test.

# --- against Debian's build ---------------------------------------------------------------

find_file(STOCK_LIBRARY libembree3.so.3 PATHS "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}" NO_DEFAULT_PATH REQUIRED)
mark_as_advanced(STOCK_LIBRARY)
get_filename_component(stock_directory "${STOCK_LIBRARY}" DIRECTORY)
set(our_directory "$<TARGET_FILE_DIR:embree>")

cbvh_test(stock_equality LIBRARIES ${CMAKE_DL_LIBS} DEFINITIONS
  "OUR_LIBRARY_DIR=\"${our_directory}\"" "STOCK_LIBRARY_DIR=\"${stock_directory}\""
  "TEST_ISAS=${isas}" "SAME_LOWEST_ISA=$<BOOL:${EMBREE_ISA_SSE2}>")
# No path in the program: LD_LIBRARY_PATH decides which library it runs on.
set_target_properties(test_stock_equality PROPERTIES SKIP_BUILD_RPATH ON)

find_program(ABIDIFF abidiff REQUIRED)
mark_as_advanced(ABIDIFF)
add_test(NAME abi COMMAND "${CMAKE_CURRENT_SOURCE_DIR}/abi.sh"
  "${ABIDIFF}" "${STOCK_LIBRARY}" "$<TARGET_FILE:embree>" "${CMAKE_BINARY_DIR}/upstream/include/embree3")
add_test(NAME debian_programs COMMAND "${CMAKE_CURRENT_SOURCE_DIR}/debian_programs.sh" "${our_directory}" ${verify_isas})

# --- getting, patching and installing upstream ----------------------------------------

add_test(NAME install COMMAND "${CMAKE_CURRENT_SOURCE_DIR}/install/test.sh" "${CMAKE_COMMAND}" "${CMAKE_BINARY_DIR}")
set_tests_properties(abi debian_programs install PROPERTIES TIMEOUT 600)
if(EMBREE_UPSTREAM_USED_ARCHIVE)
  add_test(NAME upstream COMMAND "${CMAKE_CURRENT_SOURCE_DIR}/upstream.sh"
    "${CMAKE_COMMAND}" "${EMBREE_UPSTREAM_USED_ARCHIVE}")
  set_tests_properties(upstream PROPERTIES TIMEOUT 600)
else()
  cbvh_skipped_test(upstream "the tree was not unpacked from an archive that could be spoiled")
endif()
