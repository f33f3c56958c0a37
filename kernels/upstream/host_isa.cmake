# Copyright 2026 The Embree CBVH authors
# SPDX-License-Identifier: Apache-2.0

# Sets `result` to the best of upstream's ISAs that this machine supports.
function(host_isa result)
  set(program "${CMAKE_BINARY_DIR}/CMakeFiles/host_isa.c")
  file(WRITE "${program}" [=[
#include <stdio.h>
#define HAS(f) __builtin_cpu_supports(f)
int main()
{
  int avx2 = HAS("avx2") && HAS("fma") && HAS("bmi") && HAS("bmi2");
  int avx512 = avx2 && HAS("avx512f") && HAS("avx512dq") && HAS("avx512cd") && HAS("avx512bw") && HAS("avx512vl");
  puts(avx512 ? "AVX512" : avx2 ? "AVX2" : HAS("avx") ? "AVX" : HAS("sse4.2") ? "SSE42" : "SSE2");
}
]=])
  try_run(status compiled "${CMAKE_BINARY_DIR}/CMakeFiles/host_isa" "${program}" RUN_OUTPUT_VARIABLE isa)
  if(NOT compiled OR NOT status EQUAL 0)
    message(FATAL_ERROR "  cannot find out the ISA of this machine: try CBVH_HOST_ISA_ONLY=OFF")
  endif()
  string(STRIP "${isa}" isa)
  set(${result} "${isa}" PARENT_SCOPE)
endfunction()
