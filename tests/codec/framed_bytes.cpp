// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Checksums of blocks of the kinds with frames. After an intended change, the test prints the new table.
 *
 * The vertices are integers times a power of two, the same on every machine, and so are the bytes: nothing is skipped.
 * vert_bytes.cpp tests cVERT. */

#include "support/encoded_block.h"
#include "support/pinned_bytes.h"

#include <gtest/gtest.h>

#include <cinttypes>
#include <cmath>
#include <cstdio>

namespace programs::test { namespace {

using namespace embree::cbvh;

// A sheet in units of 2^exponent.
struct Sheet {
  const char* name;
  uint32_t height; // of the block: 2^height quads per side
  int exponent;
  int origin[3];
  int alongU[3], alongV[3];
  int twist[3]; // of xy: trapezoids
  int bend[3];  // of x^2, in 1/8
  int noise[3];
  int hole; // index of a vertex that is not finite, or -1
  bool projective;
  uint64_t checksums[3]; // cGRID, cVOXEL, cLEAF
};

const Sheet sheets[] = {
    {"plane",
     3,
     0,
     {0, 0, 0},
     {32, 0, 16},
     {0, 32, -48},
     {0, 0, 0},
     {0, 0, 0},
     {0, 0, 0},
     -1,
     true,
     {0x5b2b69ba0f50580b, 0x91f0cf53e955eb95, 0x2b544291bdf75b56}},
    {"bend",
     4,
     -9,
     {-500, 7000, 12},
     {40, 3, -2},
     {-5, 37, 4},
     {0, 0, 0},
     {0, 0, 6},
     {0, 0, 0},
     -1,
     true,
     {0xf4a787e8c4aef36f, 0xaecc409b462030a5, 0x058f1b201021f498}},
    {"trapezoid",
     4,
     3,
     {0, 9, 0},
     {90, 0, 0},
     {9, 80, 0},
     {-3, 0, 1},
     {0, 0, 9},
     {2, 2, 9},
     -1,
     true,
     {0x4521d17e6b315107, 0x3c16be7368fe36c9, 0x556fd8835fb2aaa3}},
    {"noise",
     4,
     -20,
     {400, -1, 300},
     {60, 20, 10},
     {-11, 59, 7},
     {0, 0, 0},
     {0, 0, 0},
     {9, 9, 9},
     -1,
     true,
     {0x349e09616a7e8d24, 0x30c281ef12d52abc, 0x61821329bb3636dd}},
    {"rough",
     3,
     0,
     {0, 0, 0},
     {60, 0, 0},
     {0, 60, 0},
     {0, 0, 0},
     {0, 0, 0},
     {9, 9, 900},
     -1,
     true,
     {0x6e66cc7df99de815, 0xa073c1e06e800ee7, 0xdef1517d79955af1}},
    {"wall",
     3,
     -4,
     {-77, 8, 9},
     {36, 9, 0},
     {0, 0, 90},
     {0, 2, 0},
     {0, 30, 0},
     {1, 1, 1},
     -1,
     true,
     {0x9f8d6d9efc1d9314, 0xdfaeed750641256b, 0x92b4a656e6ea998e}},
    {"one quad",
     0,
     -11,
     {1234, -6543, 5},
     {33, 1, 2},
     {3, 35, -4},
     {1, 2, 9},
     {0, 0, 0},
     {3, 3, 3},
     -1,
     true,
     {0x1af57236b986b03f, 0xe66b2bbb14af1a49, 0xa6ce2008419b0e1a}},
    {"two quads per side",
     1,
     5,
     {0, 0, 0},
     {30, 4, 0},
     {0, 40, 9},
     {2, 0, 5},
     {0, 8, 8},
     {1, 2, 4},
     -1,
     true,
     {0x56b3f102e08afcd2, 0xdb6309f46b1af9e6, 0x3d7fdd0d9c3f9ca3}},
    {"dented",
     2,
     0,
     {0, 0, 0},
     {40, 0, 0},
     {0, 40, 0},
     {-9, -9, 0},
     {0, 0, 4},
     {1, 1, 1},
     -1,
     false,
     {0x8bd48ab77f992853, 0x29507d0ef63e9006, 0x57d2a4b7337b9410}},
    {"far",
     3,
     -4,
     {4000000, -1, 3000000},
     {40, 9, 0},
     {0, 50, 9},
     {3, 0, 0},
     {0, 0, 9},
     {3, 3, 3},
     -1,
     true,
     {0xd56e3344278e6158, 0x3ae07fd85b439493, 0x4fa3f3ab5902d4f8}},
    {"not finite",
     3,
     -2,
     {-100, 0, 100},
     {16, 0, 4},
     {0, 16, 2},
     {0, 0, 0},
     {0, 0, 2},
     {1, 1, 1},
     30,
     true,
     {0x4c89885a4332e938, 0x80124bc6ff408092, 0x44d05cc00594956a}},
};

std::vector<float> verticesOf(const Sheet& sheet, uint64_t seed) {
  Integers integers(seed);
  std::vector<float> vertices;
  const int quads = 1 << sheet.height;
  for (int y = 0; y <= quads; y++)
    for (int x = 0; x <= quads; x++)
      for (int k = 0; k < 3; k++) {
        const int units = sheet.origin[k] + x * sheet.alongU[k] + y * sheet.alongV[k] + x * y * sheet.twist[k] +
                          x * x * sheet.bend[k] / 8 + integers.within(sheet.noise[k]);
        const bool isHole = y * (quads + 1) + x == sheet.hole;
        vertices.push_back(isHole ? INFINITY : std::ldexp(float(units), sheet.exponent)); // 23 bits: exact
      }
  return vertices;
}

TEST(FramedBytes, MatchPinnedChecksums) {
  const Kind kinds[] = {Kind::CGRID, Kind::CVOXEL, Kind::CLEAF};
  std::string table;
  for (const Sheet& sheet : sheets) {
    const std::vector<float> vertices = verticesOf(sheet, uint64_t(&sheet - sheets) + 1);
    const size_t quads = size_t(1) << sheet.height,
                 cornerIndices[] = {0, quads, quads * (quads + 1), quads * (quads + 2)};
    float corners[4][3];
    for (int c = 0; c < 4; c++) std::copy_n(&vertices[3 * cornerIndices[c]], 3, corners[c]);
    std::string found;
    for (int k = 0; k < 3; k++) {
      SCOPED_TRACE(testing::Message() << sheet.name << ", kind " << k);
      EncodedBlock block(kinds[k], sheet.height, vertices, corners, 5, 2);
      ASSERT_TRUE(bool(block));
      EXPECT_EQ(!block.statistics.affine, sheet.projective);
      EXPECT_EQ(block.statistics.invalidQuads, sheet.hole < 0 ? 0u : 4u);
      block.get()->surface = 3; // the encoder's caller sets these
      block.get()->primID = 77;
      block.get()->tiling = blockTiling(7, 3, 0, 0);
      const uint64_t value = checksum(block.get(), block.get()->layout().bytes);
      EXPECT_EQ(value, sheet.checksums[k]);
      char text[40];
      std::snprintf(text, sizeof(text), "%s0x%016" PRIx64, k ? ", " : "", value);
      found += text;
    }
    table += "  " + std::string(sheet.name) + ": {" + found + "}\n";
  }
  if (HasFailure()) std::printf("%s", table.c_str());
}

}} // namespace programs::test
