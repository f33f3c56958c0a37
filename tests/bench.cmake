# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Tests of the benchmark: the program, the scripts around it, the report. Included by
# CMakeLists.txt, after cbvh_test.

cbvh_test(trace_timing LIBRARIES cbvh_common)
cbvh_test(bench_batches LIBRARIES cbvh_common)
target_sources(test_bench_batches PRIVATE "${CMAKE_SOURCE_DIR}/tutorials/bench/batches.cpp")
target_include_directories(test_bench_batches PRIVATE "${CMAKE_SOURCE_DIR}/tutorials/bench")

add_test(NAME bench_cli COMMAND "${CMAKE_CURRENT_LIST_DIR}/bench_cli.sh" "$<TARGET_FILE:cbvh_bench>")

# Debian's: another python3 on the path has no matplotlib.
find_program(DEBIAN_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)
mark_as_advanced(DEBIAN_PYTHON)
foreach(unit benchmark_script report_script)
  add_test(NAME ${unit} COMMAND "${DEBIAN_PYTHON}" -B "${CMAKE_CURRENT_LIST_DIR}/${unit}.py" "$<TARGET_FILE:cbvh_bench>")
endforeach()
set_tests_properties(bench_cli benchmark_script report_script PROPERTIES TIMEOUT 300)
