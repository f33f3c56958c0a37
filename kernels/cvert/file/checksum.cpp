// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* CRC-32C of eight bytes at a time, by an instruction of SSE4.2 or ARM64, or by tables. Compiled only for the lowest
 * instruction set; the instruction is selected at run time.
 *
 * Based on: Kounavis and Berry, "A Systematic Approach to Building High Performance, Software-based, CRC Generators",
 * 2005. */

#include "checksum.h"
#include <cstring>
#if defined(__x86_64__)
#include <nmmintrin.h>
#define CRC_TARGET "sse4.2"
#define CRC_OF_64 _mm_crc32_u64
#define CRC_OF_8 _mm_crc32_u8
#elif defined(__aarch64__) && defined(__linux__) && !defined(__clang__) // clang's header requires +crc for all code
#include <arm_acle.h>
#include <sys/auxv.h>
#define CRC_TARGET "+crc"
#define CRC_OF_64(crc, word) __crc32cd(uint32_t(crc), word)
#define CRC_OF_8 __crc32cb
#endif

namespace cvert {
namespace {
struct Tables {
  uint32_t at[8][256];

  Tables() {
    const uint32_t polynomial = 0x82F63B78u; // Castagnoli, bits reversed
    for (uint32_t i = 0; i < 256; i++) {
      uint32_t crc = i;
      for (int bit = 0; bit < 8; bit++) crc = (crc >> 1) ^ (crc & 1 ? polynomial : 0);
      at[0][i] = crc;
    }
    for (uint32_t i = 0; i < 256; i++)
      for (int t = 1; t < 8; t++) at[t][i] = (at[t - 1][i] >> 8) ^ at[0][at[t - 1][i] & 255];
  }
};
} // namespace

static uint32_t byTables(const uint8_t* p, size_t bytes, uint32_t crc) {
  static const Tables tables;
  for (; bytes >= 8; bytes -= 8, p += 8) {
    uint32_t low, high;
    std::memcpy(&low, p, 4);
    std::memcpy(&high, p + 4, 4);
    low ^= crc;
    crc = tables.at[7][low & 255] ^ tables.at[6][(low >> 8) & 255] ^ tables.at[5][(low >> 16) & 255] ^
          tables.at[4][low >> 24] ^ tables.at[3][high & 255] ^ tables.at[2][(high >> 8) & 255] ^
          tables.at[1][(high >> 16) & 255] ^ tables.at[0][high >> 24];
  }
  for (; bytes; bytes--, p++) crc = (crc >> 8) ^ tables.at[0][(crc ^ *p) & 255];
  return crc;
}

#if defined(CRC_TARGET)
__attribute__((target(CRC_TARGET))) static uint32_t byInstruction(const uint8_t* p, size_t bytes, uint32_t crc) {
  uint64_t wide = crc;
  for (; bytes >= 8; bytes -= 8, p += 8) {
    uint64_t word;
    std::memcpy(&word, p, 8);
    wide = CRC_OF_64(wide, word);
  }
  crc = uint32_t(wide);
  for (; bytes; bytes--, p++) crc = CRC_OF_8(crc, *p);
  return crc;
}

static bool isCrcSupported() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("sse4.2");
#else
  return (::getauxval(AT_HWCAP) & HWCAP_CRC32) != 0;
#endif
}

uint32_t fileChecksum(const void* data, size_t bytes, uint32_t before, bool isPortable) {
  static const bool hasInstruction = isCrcSupported();
  return ~(hasInstruction && !isPortable ? byInstruction : byTables)((const uint8_t*)data, bytes, ~before);
}
#else
uint32_t fileChecksum(const void* data, size_t bytes, uint32_t before, bool) {
  return ~byTables((const uint8_t*)data, bytes, ~before);
}
#endif
} // namespace cvert
