// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares the tables of the pages about cVERT blocks with the code. Tables of constants are generated here and must
 * occur literally on the page. vert_block.cpp tests the block of annotated_blocks.txt. */

#include "kernels/cbvh/base/leaf_type.h"
#include "kernels/cbvh/paper/block.h"
#include "kernels/cvert/format/motion.h"
#include "kernels/cvert/encoder/lattice.h"
#include "kernels/cvert/encoder/prim_id_encoder.h"
#include "kernels/cvert/rule/rule.h"
#include "kernels/cvert/decoder/validate.h"
#include "codec/format_pages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <cstdio>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

namespace programs::test { namespace {

using namespace embree::cbvh;

using namespace cvert;

TEST(VertFormat, ConstantsMatchPages) {
  const double side = 1u << maxVertLevel;
  EXPECT_EQ(maxVertGroups, (side / groupQuads) * (side / groupQuads));
  EXPECT_EQ(double(vertBlockQuads), side);
  EXPECT_EQ(double(sizeof(VertPrimIDs)), double(vertEdgesBytes));
  expectConstants("block.md", {{"format version, `vertFormatVersion`", vertFormatVersion},
                               {"alignment of a block, bytes", blockAlignment},
                               {"bytes after a block that decoders may read", vertReadPadding},
                               {"type of a block in the tree", VERT_BLOCK},
                               {"quads along a side of a block, at most", side},
                               {"quads along a side of a group, at most", groupQuads},
                               {"bytes of the header", vertHeaderBytes},
                               {"bytes of edges or numbers", vertEdgesBytes},
                               {"bytes of the remainders' word", vertRemaindersBytes},
                               {"bits of a remainder along an axis, at most", maxRemainderBits},
                               {"bits of a coordinate", std::log2(double(maxExtent))},
                               {"bits of a field, above which it is stored in three parts", maxFieldBits}});
  expectConstants("block.md", {{"bytes of the motion section", vertMotionBytes},
                               {"bytes of the header of a step", vertStepBytes},
                               {"time steps, at most", maxTimeSteps}});
  // The smallest speed along the normal of the triangle (0,0,0), (1,0,0), (0,1,0), relative to the sum of |n[i]
  // dir[i]|, which is 3.
  const WideTriangle<double> triangle = {{{0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};
  const double org[3] = {0.25, 0.25, -1}, dir[3] = {0.5, 0, 3};
  const auto at = intersectPlane(triangle, normalOf(triangle), org, dir);
  EXPECT_EQ(at.normalDotDir, 3);
  expectConstants("rays.md",
                  {{"ulps by which boxes are widened, `slackUlps`", slackUlps},
                   {"ulps by which sheared planes are widened, `shearedSlackUlps`", shearedSlackUlps},
                   {"a plane contains the ray up to this part of the sum, `inPlaneTolerance`", at.parallelLimit / 3},
                   {"median edge / default spacing", 1 / spacingPerEdge},
                   {"median edge / default spacing, grids of an application", 1 / spacingPerGridEdge},
                   {"median edge / default spacing, quads and triangles", 1 / spacingPerMeshEdge},
                   {"median edge / spacing that the diagonal asks for, at most", 1 / minSpacingPerEdge},
                   {"diagonal / spacing that the diagonal asks for", 1 / spacingPerDiagonal},
                   {"quads along u or v, below which the default spacing shrinks", fullSpacingQuads}});
}

// The rule in docs/error.md for a median edge of 1. The table in rays.md has the numbers.
TEST(VertFormat, DefaultSpacingMatchesPage) {
  const double ofEdge = spacingPerEdge, least = minSpacingPerEdge, ofDiagonal = spacingPerDiagonal;
  const unsigned full = fullSpacingQuads;
  for (unsigned quads = 1; quads < full; quads++)
    for (double size : {0.0, 1e9})
      EXPECT_DOUBLE_EQ(defaultSpacing(1, quads, size), ofEdge * quads / full) << quads << " quads";
  for (unsigned quads : {full, 100u}) {
    EXPECT_DOUBLE_EQ(defaultSpacing(1, quads, 1e9), ofEdge);
    EXPECT_DOUBLE_EQ(defaultSpacing(1, quads, 0), least);
    const double between = 0.5 * (ofEdge + least); // determined by the diagonal
    EXPECT_DOUBLE_EQ(defaultSpacing(1, quads, between / ofDiagonal), between);
  }
}

// Bits "| first-last | meaning |" of the table whose head is "| bits of WORD | meaning |", in order.
struct Bits {
  uint32_t first, count;
};
std::vector<Bits> bitsOf(const std::string& name, const std::string& word) {
  const std::string all = page(name), head = "| bits of " + word + " | meaning |\n|---|---|\n";
  const size_t begin = all.find(head);
  EXPECT_NE(begin, std::string::npos) << name << ": " << word;
  std::istringstream lines(all.substr(begin + head.size()));
  std::vector<Bits> bits;
  uint32_t end = 0;
  for (std::string line; std::getline(lines, line) && line.compare(0, 1, "|") == 0;) {
    unsigned first = 0, last = 0;
    if (std::sscanf(line.c_str(), "| %u-%u |", &first, &last) != 2) last = first;
    EXPECT_EQ(first, end) << "a gap, or an overlap: " << line;
    bits.push_back({first, last - first + 1});
    end = last + 1;
  }
  return bits;
}

uint32_t onesOf(const Bits& bits) { return bits.count == 32 ? ~0u : (1u << bits.count) - 1; }

// Each field is in the bits of its row: wordOf(field, ones) has ones there, and zeros in the bits of other fields.
void expectFields(const std::vector<Bits>& bits, const std::function<uint32_t(size_t field, uint32_t ones)>& wordOf) {
  for (size_t field = 0; field < bits.size(); field++)
    EXPECT_EQ(wordOf(field, onesOf(bits[field])), onesOf(bits[field]) << bits[field].first) << "field " << field;
}

// The function tests the single bit of the row.
void expectFlag(const Bits& bits, bool (*isSet)(uint32_t)) {
  EXPECT_EQ(bits.count, 1u);
  EXPECT_TRUE(isSet(1u << bits.first) && !isSet(~(1u << bits.first))) << "bit " << bits.first;
}

TEST(VertFormat, HeaderMatchesPage) {
  expectRows("block.md", "Header",
             {{"origin", offsetof(VertHeader, origin)},
              {"bounds", offsetof(VertHeader, bounds)},
              {"surface", offsetof(VertHeader, surface)},
              {"primID", offsetof(VertHeader, primID)},
              {"region", offsetof(VertHeader, region)},
              {"patchQuads", offsetof(VertHeader, patchQuads)},
              {"corners", offsetof(VertHeader, corners)},
              {"info", offsetof(VertHeader, info)},
              {"word", offsetof(VertHeader, word)}},
             0, vertHeaderBytes);
  expectRows("block.md", "Edges", {{"edges", vertHeaderBytes}}, vertHeaderBytes, vertHeaderBytes + vertEdgesBytes);
  expectRows("mesh.md", "When does a block have numbers?", {{"numbers", vertHeaderBytes}}, vertHeaderBytes,
             vertHeaderBytes + vertEdgesBytes);
}

TEST(VertFormat, FieldsMatchPages) {
  expectFields(bitsOf("block.md", "`region`"), [](size_t field, uint32_t ones) {
    return packRegion(1 + (field == 0) * ones, 1 + (field == 1) * ones, (field == 2) * ones * vertBlockQuads,
                      (field == 3) * ones * vertBlockQuads);
  });
  expectFields(bitsOf("block.md", "`patchQuads`"), [](size_t field, uint32_t ones) {
    return packPatchQuads(1 + (field == 0) * ones, 1 + (field == 1) * ones);
  });
  expectFields(bitsOf("block.md", "`edges`"), [](size_t field, uint32_t ones) {
    return packEdges(1 + (field == 0) * ones, 1, 1, 1, (field == 1) * ones, 0).low;
  });
  const std::vector<Bits> info = bitsOf("block.md", "`info`");
  ASSERT_EQ(info.size(), 11u);
  for (int k = 0; k < 3; k++) EXPECT_EQ(marginShift(5u << info[size_t(k)].first, k), 5u);
  EXPECT_EQ(shearedAxis(2u << info[3].first), 2);
  for (int i = 0; i < 2; i++) EXPECT_EQ(shearSlope(uint32_t(-7 & 31) << info[size_t(4 + i)].first, 1 + i), -7) << i;
  EXPECT_TRUE(isRaw(3u << info[3].first) && !isRaw(~(1u << info[3].first)));
  expectFlag(info[6], hasRemainders);
  EXPECT_EQ(boundsUnit(5u << info[7].first), 32u);
  expectFlag(info[8], hasEdges);
  expectFlag(info[9], hasPrimIDs);
  expectFlag(info[10], isMoving);
  const std::vector<Bits> word = bitsOf("block.md", "`word`");
  ASSERT_EQ(word.size(), 2u);
  const uint32_t none[6] = {};
  EXPECT_EQ(vertSpacing(127u << word[1].first, none).at[0], 1.0f);
  EXPECT_EQ(vertSpacing(130u << word[1].first | onesOf(word[0]), none).at[0], 8.0f);
  // exponents on y and z, the version, and reserved bits are distributed over the values of corners
  const std::vector<Bits> value = bitsOf("block.md", "value i");
  ASSERT_EQ(value.size(), 3u);
  for (uint32_t i = 0; i < 12; i++) {
    uint32_t corners[6] = {};
    auto set = [&](size_t field) {
      std::memset(corners, 0, sizeof(corners));
      corners[i / 2] = (onesOf(value[field]) << value[field].first) << 16 * (i % 2);
    };
    auto spacing = [&](int k) { return bitsOfFloat(vertSpacing(0, corners).at[k]); };
    set(0);
    EXPECT_EQ(cornerCoordinate(corners[cornerPair(int(i / 3), int(i % 3))], int(i / 3), int(i % 3)),
              int(onesOf(value[0])));
    EXPECT_EQ(spacing(1) | spacing(2) | versionOfCorners(corners[4], corners[5]) |
                  reservedOfCorners(corners[4], corners[5]),
              0u);
    set(1);
    EXPECT_EQ(spacing(2), i < 8 ? 1u << (23 + i) : 0u);
    EXPECT_EQ(spacing(1), 0u);
    EXPECT_EQ(reservedOfCorners(corners[4], corners[5]), i < 8 ? 0u : 1u << (i - 8));
    set(2);
    EXPECT_EQ(spacing(1), i < 8 ? 1u << (23 + i) : 0u);
    EXPECT_EQ(spacing(2), 0u);
    EXPECT_EQ(versionOfCorners(corners[4], corners[5]), i < 8 ? 0u : 1u << (i - 8));
  }
  const std::vector<Bits> remainders = bitsOf("block.md", "the remainders' word");
  ASSERT_EQ(remainders.size(), 5u);
  for (int k = 0; k < 3; k++) EXPECT_EQ(remainderBits(19u << remainders[size_t(k)].first, k), 19u);
  EXPECT_EQ(remainderOffset(300u << remainders[4].first), 300u);
  // b0, b1, b2, main axis, slopes
  const std::vector<Bits> cell = bitsOf("block.md", "a word");
  ASSERT_EQ(cell.size(), 6u);
  for (int i = 0; i < 3; i++) EXPECT_EQ(cellBits(9u << cell[size_t(i)].first, i), 9) << i;
  EXPECT_EQ(cellMainAxis(2u << cell[3].first), 2);
  for (int i = 0; i < 2; i++) EXPECT_EQ(cellSlope(uint32_t(-7 & 31) << cell[size_t(4 + i)].first, 1 + i), -7) << i;
}

TEST(VertFormat, MotionMatchesPage) {
  expectRows("block.md", "The motion section",
             {{"begin", offsetof(VertMotion, begin)},
              {"end", offsetof(VertMotion, end)},
              {"numSteps", offsetof(VertMotion, numSteps)},
              {"steps", offsetof(VertMotion, steps)}},
             0, vertMotionBytes);
  expectRows("block.md", "A later step",
             {{"origin", offsetof(VertStep, origin)},
              {"info", offsetof(VertStep, info)},
              {"word", offsetof(VertStep, word)},
              {"corners", offsetof(VertStep, corners)},
              {"rotation", offsetof(VertStep, rotation)},
              {"matrix", offsetof(VertStep, matrix)},
              {"bounds", offsetof(VertStep, bounds)},
              {"endBounds", offsetof(VertStep, endBounds)}},
             0, vertStepBytes);
  const std::vector<Bits> info = bitsOf("block.md", "a step's `info`");
  ASSERT_EQ(info.size(), 6u);
  expectFlag(info[1], hasRemainders);
  expectFlag(info[2], isFirstCellRotated);
  expectFlag(info[3], laterStepStoresUpperBits);
  expectFlag(info[4], hasMargins);
  EXPECT_EQ(beginBoundsUnit(5u << info[5].first), 32u);
  const std::vector<Bits> rotation = bitsOf("block.md", "`rotation`");
  ASSERT_EQ(rotation.size(), 5u);
  EXPECT_EQ(rotation[0].count, 16u);
  EXPECT_TRUE(areResidualsRotated(1u << 9, 9) && !areResidualsRotated(~(1u << 9), 9));
  EXPECT_EQ(rotationShift(3u << rotation[1].first), 4u);
  EXPECT_EQ(endBoundsUnit(5u << rotation[2].first), 32u);
  VertStep step = {};
  step.rotation = 3u << rotation[1].first | uint32_t(uint8_t(-100)) << rotation[4].first;
  for (int i = 0; i < 8; i++) ((int8_t*)step.matrix)[i] = int8_t(11 * i - 40);
  for (int i = 0; i < 9; i++) EXPECT_EQ(rotationEntry(step, uint32_t(i)), i < 8 ? 11 * i - 40 : -100);

  // floor((M r + 2^(6-q)) / 2^(7-q))
  for (uint32_t q = 0; q <= 6; q++)
    for (int x = -50; x <= 50; x++) {
      const double sum = 91.0 * x - 17 * 3.0 + 5 * x * x;
      EXPECT_EQ(rotatedResidual(91, -17, 5, x, 3, x * x, rotationShift(q << 16)),
                std::floor((sum + std::exp2(6.0 - q)) / std::exp2(7.0 - q)));
    }
  VertMotion motion = {0.25f, 0.75f, 5, 0};
  EXPECT_TRUE(isPresent(motion, 0.25f) && isPresent(motion, 0.75f) && !isPresent(motion, 0.2f) &&
              !isPresent(motion, 0.8f));
  EXPECT_EQ(timeInMotion(motion, 0.5f).segment, 2u);
  EXPECT_EQ(timeInMotion(motion, 0.75f).segment, 3u);
  EXPECT_EQ(timeInMotion(motion, 0.75f).fraction, 1.0f);
  EXPECT_EQ(timeInMotion(motion, 0.4375f).fraction, 0.5f);
  // differences of times overflow
  motion = {-3e38f, 3e38f, 5, 0};
  EXPECT_EQ(timeInMotion(motion, 3e38f).segment, 3u);
  EXPECT_EQ(timeInMotion(motion, 3e38f).fraction, 1.0f);
  EXPECT_EQ(timeInMotion(motion, 0.5f).segment, 0u);
  EXPECT_EQ(timeInMotion(motion, 0.5f).fraction, 0.0f);
}

TEST(VertFormat, NumbersMatchPage) {
  const std::vector<Bits> bits = bitsOf("mesh.md", "the numbering");
  ASSERT_EQ(bits.size(), 8u);
  EXPECT_EQ(bits[0].count, 2u);
  expectFlag(bits[6], haveTrianglePairs);
  expectFlag(bits[1], isTriangleNumbering);
  expectFlag(bits[2], isSingleTriangleNumbering);
  EXPECT_EQ(packFirstCorners(3, 0), 3u << bits[3].first);
  EXPECT_EQ(packFirstCorners(0, 3), 3u << bits[4].first);
  EXPECT_EQ(firstCornerOfTriangle(2u << bits[3].first, false), 2u);
  EXPECT_EQ(firstCornerOfTriangle(2u << bits[4].first, true), 2u);
  EXPECT_EQ(patternNumber(primIDsRecursive | 0xA5u << bits[5].first, VertPrimIDs{0, 0}, 5, 8), 0xA5u);

  // rows: X x + Y y
  EXPECT_EQ(patternNumber(primIDsInRows, VertPrimIDs{3u, ~0u}, 5, 4), 11u);
  // recursive: C, and bytes of X and Y for bits of x and y, twice for triangles
  const VertPrimIDs bytes = {0x40100401u, 0xC0300C03u};
  EXPECT_EQ(patternNumber(primIDsRecursive | 0xFFu << 8, bytes, 5, 8), 0xFFu ^ 0x01u ^ 0x10u ^ 0xC0u);
  EXPECT_EQ(patternNumber(primIDsRecursive | primIDsOfTriangles, bytes, 2, 1), 2 * (0x04u ^ 0x03u));
  EXPECT_EQ(patternNumber(primIDsRecursive | primIDsOfTriangles | primIDsOfTrianglePairs, bytes, 2, 1), 0x04u ^ 0x03u);
  // table: its bits
  alignas(16) uint8_t block[256] = {};
  VertHeader& header = *(VertHeader*)block;
  header.primID = 1000;
  header.region = packRegion(3, 2, 0, 0);
  header.info = 1u << 30;
  header.patchQuads = primIDsInTable;
  const VertPrimIDs table = {128, 11};
  std::memcpy(&header + 1, &table, sizeof(table));
  const uint32_t bit = 11 * (3 * 1 + 2); // of quad (2,1)
  for (uint32_t b = 0; b < 11; b++)
    if ((1234u >> b) & 1) block[128 + (bit + b) / 8] |= uint8_t(1u << ((bit + b) % 8));
  EXPECT_EQ(numberOfQuad(&header, 2, 1), 2234u);
  EXPECT_EQ(numberOfQuad(&header, 1, 1), 1000u);
  EXPECT_EQ(numberOfQuad(&header, 3, 15), 2234u) << "quads outside have the number of the last quad";

  // (w1,w2), (w2,w0) or (w0,w1)
  const float a = 0.25f, b = 0.125f, w[] = {1 - a - b, a, b};
  for (uint32_t first = 0; first < 3; first++) {
    const PrimitiveParameters p = primitiveParameters(primIDsOfTriangles | packFirstCorners(first, 0), false, a, b);
    EXPECT_EQ(p.u, w[(1 + first) % 3]);
    EXPECT_EQ(p.v, w[(2 + first) % 3]);
    const PrimitiveParameters q =
        primitiveParameters(primIDsOfTriangles | packFirstCorners(0, first), true, 1 - a, 1 - b);
    EXPECT_EQ(q.u, w[(1 + first) % 3]);
    EXPECT_EQ(q.v, w[(2 + first) % 3]);
  }
  EXPECT_EQ(primitiveParameters(primIDsOfTriangles | packFirstCorners(0, 2), true, a, b).u, 0)
      << "outside of the second triangle, w0 is negative and is clamped to 0";
  const PrimitiveParameters own = primitiveParameters(0, true, a, b);
  EXPECT_EQ(own.u, a);
  EXPECT_EQ(own.v, b);
  const auto primitive = [&](uint32_t ofNumbers, bool isSecond) {
    header.patchQuads = primIDsInTable | ofNumbers;
    return primitiveOfQuad(&header, 2, 1, isSecond).primID;
  };
  EXPECT_EQ(primitive(0, true), 2234u);
  EXPECT_EQ(primitive(primIDsOfTriangles, true), 2235u);
  EXPECT_EQ(primitive(primIDsOfTriangles, false), 2234u);
  EXPECT_EQ(primitive(primIDsOfTriangles | primIDsOfOneTriangle, true), 2234u);

  // X and Y elsewhere, and the distance of second triangles
  const VertPrimIDs at = {200, 0};
  std::memcpy(&header + 1, &at, sizeof(at));
  const uint32_t halves[] = {3, 5, ~0u - 99};
  std::memcpy(block + 200, halves, sizeof(halves));
  header.patchQuads = primIDsInRows | primIDsOfTriangles | primIDsOfTrianglePairs;
  EXPECT_EQ(primitiveOfQuad(&header, 2, 1, false).primID, 1011u);
  EXPECT_EQ(primitiveOfQuad(&header, 2, 1, true).primID, 911u);

  // a table of triangles: entries of 7 bits; 2 of them are the first corner
  std::memset(block + 128, 0, 128);
  const VertPrimIDs ofTriangles = {128, 7};
  std::memcpy(&header + 1, &ofTriangles, sizeof(ofTriangles));
  header.patchQuads = primIDsInTriangleTable | primIDsOfTriangles;
  const uint32_t entry = 2 * (3 * 1 + 2) + 1; // of the second triangle of quad (2,1)
  for (uint32_t b = 0; b < 7; b++)
    if (((21u << 2 | 2u) >> b) & 1) block[128 + (7 * entry + b) / 8] |= uint8_t(1u << ((7 * entry + b) % 8));
  EXPECT_EQ(primitiveOfQuad(&header, 2, 1, false).primID, 1000u);
  EXPECT_EQ(primitiveOfQuad(&header, 2, 1, true).primID, 1021u);
  EXPECT_EQ(firstCornerOfTriangle(primitiveOfQuad(&header, 2, 1, true).numbering, true), 2u);
}

TEST(VertFormat, NumbersOfTrianglesRoundTrip) {
  struct Quad {
    uint32_t first, second, firstCorners;
  };
  struct Case {
    const char* name;
    uint32_t pattern;
    bool hasHalves;
    std::function<Quad(uint32_t)> quad;
  };
  const uint32_t turned = packFirstCorners(2, 1);
  std::vector<uint32_t> shuffled(2 * 20 * 18);
  for (uint32_t i = 0; i < shuffled.size(); i++) shuffled[i] = (i * 337 + 11) % uint32_t(shuffled.size());
  const auto recursive = [](uint32_t i) {
    uint32_t n = 0;
    for (uint32_t k = 0; k < 5; k++) n |= ((i % 20 >> k) & 1) << (2 * k) | (((i / 20 - 2) >> k) & 1) << (2 * k + 1);
    return n;
  };
  const Case cases[] = {
      {"next to each other", primIDsInRows, false, [&](uint32_t i) { return Quad{2 * i, 2 * i + 1, turned}; }},
      {"first halves before second ones", primIDsInRows, true, [&](uint32_t i) { return Quad{i, 360 + i, turned}; }},
      {"second halves before first ones", primIDsInRows, true, [&](uint32_t i) { return Quad{360 + i, i, turned}; }},
      {"recursive", primIDsRecursive, true,
       [&](uint32_t i) { return Quad{recursive(i), recursive(i) + 1024, turned}; }},
      {"first halves in any order", primIDsInTable, true,
       [&](uint32_t i) { return Quad{shuffled[i], shuffled[i] + 720, turned}; }},
      {"any order", primIDsInTriangleTable, false,
       [&](uint32_t i) { return Quad{shuffled[2 * i], shuffled[2 * i + 1], turned}; }},
      {"any first corners", primIDsInTriangleTable, false,
       [&](uint32_t i) { return Quad{2 * i, 2 * i + 1, packFirstCorners(i % 3, i / 7 % 3)}; }}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    QuadNumbers numbers;
    numbers.numbering = primIDsOfTriangles;
    numbers.width = 20;
    for (unsigned i = 0; i < 20 * 18; i++) {
      const Quad quad = c.quad(i);
      numbers.numbers.push_back(quad.first);
      numbers.seconds.push_back(quad.second);
      numbers.firstCorners.push_back(uint8_t(quad.firstCorners));
    }
    NumbersEncoder encoder;
    encoder.choosePattern(numbers, 16, 2, 4, 16);
    alignas(16) uint8_t bytes[NumbersEncoder::maxBytes + 128] = {};
    VertHeader& header = *(VertHeader*)bytes;
    header.region = packRegion(4, 16, 16, 0);
    header.info = 1u << 30;
    header.patchQuads = encoder.numbering;
    std::memcpy(&header + 1, &encoder.pattern, sizeof(encoder.pattern));
    const size_t size = encoder.finish(&header, 75);
    EXPECT_EQ(patternOfPrimIDs(encoder.numbering), c.pattern);
    EXPECT_EQ(haveTrianglePairs(encoder.numbering), c.hasHalves);
    if (c.hasHalves && c.pattern != primIDsInTable) { EXPECT_EQ(size, 76 + sizeof(VertTrianglePairs)); }
    for (unsigned y = 0; y < 16; y++)
      for (unsigned x = 0; x < 4; x++) {
        const unsigned i = (y + 2) * 20 + x + 16;
        for (bool isSecond : {false, true}) {
          const QuadPrimitive primitive = primitiveOfQuad(&header, x, y, isSecond);
          EXPECT_EQ(primitive.primID, isSecond ? numbers.seconds[i] : numbers.numbers[i]);
          EXPECT_EQ(firstCornerOfTriangle(primitive.numbering, isSecond),
                    firstCornerOfTriangle(numbers.firstCorners[i], isSecond));
        }
      }
  }
}

}} // namespace programs::test
