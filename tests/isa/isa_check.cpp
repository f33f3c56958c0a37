// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* On a machine without the ISA for which a program is compiled, ends the program with status 77 and a message before
 * any of its code runs. This file itself is compiled for the lowest ISA. */

#include <cstdio>
#include <cstring>
#include <unistd.h>

extern const char* const programIsa; // in Embree's spelling, a constant of the program

// Runs before the constructors of the program's own objects, which have no priority.
__attribute__((constructor(101))) static void checkIsa() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  bool runs = false;
  if (!std::strcmp(programIsa, "SSE2")) runs = __builtin_cpu_supports("sse2");
  else if (!std::strcmp(programIsa, "SSE4.2")) runs = __builtin_cpu_supports("sse4.2");
  else if (!std::strcmp(programIsa, "AVX")) runs = __builtin_cpu_supports("avx");
  else if (!std::strcmp(programIsa, "AVX2"))
    runs = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi") &&
           __builtin_cpu_supports("bmi2");
  else if (!std::strcmp(programIsa, "AVX512"))
    runs = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512bw") &&
           __builtin_cpu_supports("avx512vl");
  else {
    std::fprintf(stderr, "FAILED: unknown ISA %s\n", programIsa);
    _exit(1);
  }
#else
  const bool runs = !std::strcmp(programIsa, "SSE2"); // Embree's name for NEON
#endif
  if (runs) return;
  std::printf("skipped: this machine does not support %s\n", programIsa);
  std::fflush(stdout);
  _exit(77);
}
