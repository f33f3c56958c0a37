# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# block_traversal.cpp under libFuzzer, AddressSanitizer and UndefinedBehaviorSanitizer, for
# the narrowest and the widest ISA, half a minute each. Compiled by clang whatever compiles the rest: the kernels' headers hold
# all that it runs, the library only gives it a scene. Included by CMakeLists.txt.
#
# For longer, on a corpus that is kept:
#   build/release/tests/fuzz/block_traversal_native --seeds=corpus -max_total_time=3600 corpus

find_program(FUZZ_COMPILER NAMES clang++ clang++-14)
mark_as_advanced(FUZZ_COMPILER)
set(fuzz_flags -std=c++17 -O1 -g1 -fno-strict-aliasing -fno-sanitize-recover=all
  # vptr needs the type information that the library hides
  -fsanitize=fuzzer,address,undefined -fno-sanitize=vptr)
if(FUZZ_COMPILER)
  file(WRITE "${CMAKE_BINARY_DIR}/CMakeFiles/fuzz.cpp" "extern \"C\" int LLVMFuzzerTestOneInput(const char*, unsigned long) { return 0; }\n")
  execute_process(COMMAND "${FUZZ_COMPILER}" ${fuzz_flags} "${CMAKE_BINARY_DIR}/CMakeFiles/fuzz.cpp" -o "${CMAKE_BINARY_DIR}/CMakeFiles/fuzz"
    RESULT_VARIABLE status OUTPUT_QUIET ERROR_QUIET)
endif()
if(NOT FUZZ_COMPILER)
  set(fuzz_skipped "no program named clang++, see scripts/packages")
elseif(NOT status EQUAL 0)
  set(fuzz_skipped "${FUZZ_COMPILER} has no libFuzzer or no sanitizers, see scripts/packages")
else()
  set(fuzz_skipped "")
endif()

# As upstream's own targets are compiled: the scene has the library's layout.
set(fuzz_definitions "${embree_definitions}")
list(TRANSFORM fuzz_definitions PREPEND "-D")

# cbvh_fuzz(NAME FLAGS...)
function(cbvh_fuzz name)
  if(fuzz_skipped)
    cbvh_skipped_test(fuzz_${name} "${fuzz_skipped}")
    return()
  endif()
  set(program "${CMAKE_CURRENT_BINARY_DIR}/fuzz/${name}")
  set(corpus "${program}.corpus")
  file(MAKE_DIRECTORY "${corpus}")
  add_custom_command(OUTPUT "${program}"
    COMMAND ${CMAKE_CXX_COMPILER_LAUNCHER} "${FUZZ_COMPILER}" ${fuzz_flags} ${ARGN} ${fuzz_definitions}
      -I "${CMAKE_BINARY_DIR}/upstream" -I "${CMAKE_BINARY_DIR}/upstream/include"
      -MD -MT "${program}" -MF "${program}.d" -c "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/block_traversal.cpp" -o "${program}.o"
    COMMAND "${FUZZ_COMPILER}" ${fuzz_flags} ${ARGN} "${program}.o"
      "${CMAKE_BINARY_DIR}/upstream/kernels/cbvh/node_tables.cpp" "${CMAKE_BINARY_DIR}/upstream/common/simd/sse.cpp"
      "$<TARGET_FILE:embree>" "-Wl,-rpath,$<TARGET_FILE_DIR:embree>" -o "${program}"
    DEPENDS embree "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/block_traversal.cpp"
    DEPFILE "${program}.d" VERBATIM)
  add_custom_target(fuzz_${name} ALL DEPENDS "${program}")
  add_test(NAME fuzz_${name} COMMAND "${program}" --seeds=${corpus} -max_len=8192 -timeout=20 -max_total_time=30 -print_final_stats=1 "${corpus}")
  set_tests_properties(fuzz_${name} PROPERTIES TIMEOUT 180)
endfunction()

cbvh_fuzz(block_traversal_sse42 -msse4.2)
cbvh_fuzz(block_traversal_native -march=native)
