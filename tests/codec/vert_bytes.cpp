// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Checksums of cVERT blocks. After an intended change, the test prints the new table.
 *
 * The vertices are integers times a power of two, the same on every machine, and so are the bytes: nothing is skipped.
 * framed_bytes.cpp tests the kinds with frames. */

#include "kernels/cvert/encoder/block_encoder.h"
#include "support/pinned_bytes.h"

#include <gtest/gtest.h>

#include <cinttypes>
#include <cstdio>
#include <memory>
#include <string>

namespace programs::test { namespace {

using namespace cvert;

// A sheet in lattice spacings.
struct Sheet {
  const char* name;
  uint32_t quadsX, quadsY;
  int exponent; // of the spacing
  int origin[3];
  int alongU[3], alongV[3];
  int bend[3]; // of x^2 - xy, in 1/8
  int noise[3];
  int hole; // index of a vertex that is not finite, or -1
  uint64_t checksum;
};

// Slopes of words and boxes; fields of 0 bits, of up to 32 bits and of more; all forms of incomplete groups; raw
// blocks.
// clang-format off
const Sheet sheets[] = {
  {"plane",                  16, 16,   0, {0, 0, 0},
   {32, 0, 16},  {0, 32, -48},  {0, 0, 0},  {0, 0, 0},         -1, 0x2ba85372be8a0c4f},
  {"bend along z",           16, 16,  -9, {-5000, 70000, 12},
   {40, 3, -2},  {-5, 37, 4},   {0, 0, 6},  {0, 0, 0},         -1, 0xbc44158cf000b493},
  {"bend along all",         16, 16, -20, {4000000, -1, 3000000},
   {30, 20, 10}, {-11, 29, 7},  {5, -3, 9}, {0, 0, 0},         -1, 0xf72724f6ebe2d85a},
  {"noise of a step",        16, 16,   3, {100, 200, 300},
   {36, 0, 0},   {0, 0, 36},    {0, 4, 0},  {1, 1, 1},         -1, 0x57003f48b5efab8b},
  {"noise along the normal", 16, 16,  -4, {-77, 8, 9},
   {36, 9, 0},   {0, 7, 36},    {0, 2, 0},  {2, 40, 1},        -1, 0x74741e1314148dd4},
  {"axis by axis",           16, 16,  -7, {-9000, -9000, 0},
   {40, 0, 0},   {0, 40, 0},    {0, 0, 0},  {900, 2000, 4000}, -1, 0xcf99265420553d65},
  {"one quad",                1,  1, -11, {123456, -654321, 5},
   {33, 1, 2},   {3, 35, -4},   {0, 0, 0},  {3, 3, 3},         -1, 0xe472c6f29742528f},
  {"a row",                  16,  1,  -5, {0, 0, -400},
   {31, 2, 17},  {0, 0, 40},    {1, 1, 1},  {2, 3, 1},         -1, 0x5b96558fdf6ec5e7},
  {"three columns",           3, 16,   0, {1, 2, 3},
   {10, 40, 5},  {50, -6, 1},   {3, 0, 8},  {4, 0, 12},        -1, 0x51c41a8555fc9d63},
  {"7 x 13",                  7, 13,  30, {-31, 41, -59},
   {26, 53, 58}, {97, -93, 23}, {8, 4, 6},  {2, 6, 4},         -1, 0x8086d475fac6b926},
  {"raw: not finite",         9,  6,  -2, {-100, 0, 100},
   {16, 0, 4},   {0, 16, 2},    {0, 0, 2},  {1, 1, 1},         17, 0x8bc8153960f9bd6d},
  {"with remainders",        16,  4,  -8, {0, 0, 0},
   {1100, 0, 0}, {0, 40, 9},    {0, 0, 1},  {5, 5, 5},         -1, 0x6ffcf07f9683d796},
  {"remainders and slopes",   8,  8,  -8, {0, 0, 0},
   {1100, 0, 0}, {0, 400, 9},   {1000, 900, 1000}, {0, 0, 0},  -1, 0x43e8e853773623fc},
  {"equal normals",           8,  8,   0, {0, 0, 0},
   {16, 0, -16}, {0, 16, 0},    {0, 0, 0},  {0, 0, 0},         -1, 0x802180a51c0813f9},
};
// clang-format on

void fill(VertEncoder& encoder, const Sheet& sheet, uint64_t seed) {
  Integers integers(seed);
  for (uint32_t y = 0; y <= sheet.quadsY; y++)
    for (uint32_t x = 0; x <= sheet.quadsX; x++) {
      const uint32_t v = y * (sheet.quadsX + 1) + x;
      for (int k = 0; k < 3; k++) {
        const int i = int(x), j = int(y);
        const int steps = sheet.origin[k] + i * sheet.alongU[k] + j * sheet.alongV[k] +
                          (i * i - i * j) * sheet.bend[k] / 8 + integers.within(sheet.noise[k]);
        encoder.vertices[v][k] = std::ldexp(float(steps), sheet.exponent); // 23 bits: exact
        if (int(v) == sheet.hole) encoder.vertices[v][k] = INFINITY;
      }
    }
}

// Inside a patch; sheets with an odd width have edges.
VertPlacement placementOf(const Sheet& sheet) {
  const uint32_t region = packRegion(sheet.quadsX, sheet.quadsY, 32, 16), patch = packPatchQuads(100, 50);
  return sheet.quadsX % 2 ? VertPlacement(region, patch, packEdges(100, 7, 31, 50, 5, 1))
                          : VertPlacement(region, patch);
}

TEST(VertBytes, MatchPinnedChecksums) {
  const auto encoder = std::make_unique<VertEncoder>();
  struct Room {
    alignas(16) uint8_t bytes[VertEncoder::maxBytes];
  };
  const auto room = std::make_unique<Room>();
  std::string table;
  unsigned raw = 0, byAxis = 0, sheared = 0;
  for (const Sheet& sheet : sheets) {
    SCOPED_TRACE(sheet.name);
    fill(*encoder, sheet, uint64_t(&sheet - sheets) + 1);
    VertStatistics statistics;
    const size_t size = encoder->encode(placementOf(sheet), room->bytes, statistics);
    const uint64_t found = checksum(room->bytes, size);
    EXPECT_EQ(found, sheet.checksum);
    char row[100];
    std::snprintf(row, sizeof(row), "  %s: 0x%016" PRIx64 "\n", sheet.name, found);
    table += row;
    const VertHeader* header = (const VertHeader*)room->bytes;
    EXPECT_EQ(isRaw(header->info), std::string(sheet.name).compare(0, 3, "raw") == 0);
    raw += isRaw(header->info);
    byAxis += !isRaw(header->info) && isByAxis(header->word);
    sheared += !isRaw(header->info) && shearSlope(header->info, 1) != 0 && shearSlope(header->info, 2) != 0;
  }
  EXPECT_EQ(raw, 1u);
  EXPECT_GE(byAxis, 1u);
  EXPECT_GE(sheared, 3u);
  if (HasFailure()) std::printf("%s", table.c_str());
}

}} // namespace programs::test
