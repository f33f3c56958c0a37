// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

// Helpers of all fuzz targets. They do not require a library.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#define REQUIRE(condition) \
  do { \
    if (!(condition)) { \
      std::fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort(); \
    } \
  } while (false)

namespace programs::test {

// Writes the initial corpus of a target for --seeds=FOLDER. Each target defines it.
void writeSeeds(const std::string& folder);

inline void writeSeed(const std::string& path, const std::string& bytes) {
  FILE* file = std::fopen(path.c_str(), "wb");
  REQUIRE(file && std::fwrite(bytes.data(), 1, bytes.size(), file) == bytes.size() && std::fclose(file) == 0);
}

// Memory of exactly this size, so that sanitizers detect accesses beyond its end.
class ExactMemory {
public:
  ExactMemory(const void* source, size_t bytes, size_t alignment) {
    REQUIRE(posix_memalign(&memory, alignment, bytes) == 0);
    std::memcpy(memory, source, bytes);
  }
  ExactMemory(const ExactMemory&) = delete;
  ~ExactMemory() { std::free(memory); }
  void* get() const { return memory; }

private:
  void* memory = nullptr;
};

} // namespace programs::test

extern "C" inline __attribute__((used)) int LLVMFuzzerInitialize(int* argc, char*** argv) {
  const std::string option = "--seeds=";
  for (int i = 1; i < *argc; i++)
    if (option.compare(0, option.size(), (*argv)[i], option.size()) == 0)
      ::programs::test::writeSeeds((*argv)[i] + option.size());
  return 0;
}
