// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* What FORMAT_VERT.md says in numbers: each is read from its sentence or table, and compared with what the code
 * does, so the two cannot drift. vert_block.cpp has the block that the page shows byte by byte. */

#include "kernels/cbvh/base/primitive_type.h"
#include "kernels/cbvh/framed/block.h"
#include "kernels/cbvh/vert/motion_format.h"
#include "kernels/cbvh/surface/lattice.h"
#include "kernels/cbvh/vert/rule.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <regex>
#include <string>
#include <vector>

namespace cbvh::test {
namespace {

using namespace embree::cbvh;

std::string page()
{
  std::ifstream file(FORMAT_VERT_MD);
  return std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

// The page on one line, so that sentences may be broken anywhere.
std::string text()
{
  return std::regex_replace(page(), std::regex("\\s+"), " ");
}

/* The numbers of the only sentence that has this form, in which # is a number. */
std::vector<double> numbersOf(std::string form)
{
  form = std::regex_replace(form, std::regex("[.^()*+?\\[\\]{}|`]"), "\\$&");
  form = std::regex_replace(form, std::regex("#"), "(-?[0-9]+)");
  const std::string all = text();
  const std::regex pattern(form);
  std::vector<double> numbers;
  size_t sentences = 0;
  for (std::sregex_iterator i(all.begin(), all.end(), pattern), end; i != end; ++i, sentences++)
    for (size_t n = 1; n < i->size(); n++) numbers.push_back(std::stod((*i)[n]));
  EXPECT_EQ(sentences, 1u) << "sentences of the form " << form;
  return numbers;
}

typedef std::vector<double> Numbers;

TEST(VertFormat, TheVersionIsTheOneOfThePage)
{
  EXPECT_EQ(numbersOf("This is format version # (`vertFormatVersion`"), Numbers{vertFormatVersion});
}

TEST(VertFormat, SizesAreThoseOfThePage)
{
  const double side = 1u << maxVertHeight, group = groupQuads;
  EXPECT_EQ(numbersOf("A block starts at a multiple of # bytes"), Numbers{blockAlignment});
  EXPECT_EQ(numbersOf("its type in the top-level BVH is #, or # if it moves."), (Numbers{double(VERT_BLOCK), double(MOVING_VERT_BLOCK)}));
  EXPECT_EQ(numbersOf("Behind header and edges or numbers it has # bytes:"), Numbers{vertMotionBytes});
  EXPECT_EQ(numbersOf("| `numSteps` | 2 to #, at even times"), Numbers{maxTimeSteps});
  EXPECT_EQ(numbersOf("step, # bytes | margins of groups"), Numbers{vertStepBytes});
  EXPECT_EQ(numbersOf("**Block.** Up to # x # quads of a patch"), (Numbers{side, side}));
  EXPECT_EQ(numbersOf("A patch is cut every # quads, so its last blocks"), Numbers{side});
  EXPECT_EQ(numbersOf("**Group.** Up to # x # quads of a block. A block is cut every # quads"), (Numbers{group, group, group}));
  EXPECT_EQ(maxVertGroups, (side/group)*(side/group));
  const Numbers bits = numbersOf("A **coordinate** is an integer of # bits"), power = numbersOf("that are wider than #^# steps");
  ASSERT_EQ(bits.size(), 1u);
  ASSERT_EQ(power.size(), 2u);
  EXPECT_EQ(std::exp2(bits[0]), double(maxExtent));
  EXPECT_EQ(std::pow(power[0], power[1]), double(maxExtent));
  EXPECT_EQ(numbersOf("Where that is more than # bits, the b0 bits of all"), Numbers{maxFieldBits});
}

// The rule of the page, of a median edge of 1.
TEST(VertFormat, TheDefaultSpacingIsThatOfThePage)
{
  const Numbers edge = numbersOf("largest power of two that is at most #/# of the median edge"),
                full = numbersOf("and with q < # quads there at most q/# of that"),
                diagonal = numbersOf("Nor is it more than #/# of the diagonal of the cage's bounds"),
                finest = numbersOf("but for that it is not less than #/# of that edge");
  ASSERT_TRUE(edge.size() == 2 && full.size() == 2 && diagonal.size() == 2 && finest.size() == 2);
  ASSERT_EQ(full[0], full[1]);
  const double ofEdge = edge[0]/edge[1], ofDiagonal = diagonal[0]/diagonal[1], least = finest[0]/finest[1];
  ASSERT_LT(least, ofEdge);
  for (unsigned quads = 1; quads < unsigned(full[0]); quads++)
    for (double size : {0.0, 1e9}) EXPECT_DOUBLE_EQ(defaultSpacing(1, quads, size), ofEdge*quads/full[0]) << quads << " quads";
  for (unsigned quads : {unsigned(full[0]), 100u}) {
    EXPECT_DOUBLE_EQ(defaultSpacing(1, quads, 1e9), ofEdge);
    EXPECT_DOUBLE_EQ(defaultSpacing(1, quads, 0), least);
    const double between = 0.5*(ofEdge + least); // the diagonal's
    EXPECT_DOUBLE_EQ(defaultSpacing(1, quads, between/ofDiagonal), between);
  }
}

TEST(VertFormat, LatticesAreThoseOfThePage)
{
  const Numbers finest = numbersOf("A lattice is not finer than #^# of the face's largest coordinate");
  ASSERT_EQ(finest.size(), 2u);
  for (double largest : {1.0, 1.5, 1.99, 1000.0}) {
    const double spacing = std::ldexp(1.0, latticeExponent(1e-30, largest));
    EXPECT_GE(spacing, std::pow(finest[0], finest[1])*largest);
    EXPECT_LE(spacing, 2*std::pow(finest[0], finest[1])*largest);
  }
  EXPECT_EQ(latticeExponent(0.99, 1), -1);
  EXPECT_EQ(latticeExponent(1, 1), 0);
}

TEST(VertFormat, RaysAreWidenedAsThePageSays)
{
  EXPECT_EQ(numbersOf("both widened by # ulps of the distance to the farthest plane"), Numbers{slackUlps});
  EXPECT_EQ(numbersOf("between planes of h by # ulps of the three distances"), Numbers{shearedSlackUlps});
}

// The triangle (0,0,0), (1,0,0), (0,1,0), seen along (x,y,1).
TEST(VertFormat, RaysLieInPlanesAsThePageSays)
{
  const Numbers least = numbersOf("(|n.dir| is at most #^# of the sum of |n[i] dir[i]|)");
  ASSERT_EQ(least.size(), 2u);
  const WideTriangle<double> triangle = {{{0, 1, 0}, {0, 0, 1}, {0, 0, 0}}};
  const double org[3] = {0.25, 0.25, -1}, dir[3] = {0.5, 0, 3};
  const auto at = meetPlane(triangle, normalOf(triangle), org, dir);
  EXPECT_EQ(at.speed, 3);
  EXPECT_FLOAT_EQ(float(at.least), float(3*std::pow(least[0], least[1])));
}

struct Row
{
  size_t offset, bytes;
  std::string field;
};

// Rows "| offset | type | `field` | meaning |" between two places of the page.
std::vector<Row> rowsOf(const std::string& from, const std::string& to)
{
  const std::map<std::string, size_t> bytesOf = {{"float", 4}, {"float[3]", 12}, {"uint32", 4}, {"uint16[4][3]", 24}, {"uint16[4]", 8}, {"int8[8]", 8}, {"uint32[2]", 8}};
  const std::string all = page();
  const size_t begin = all.find(from), end = all.find(to, begin);
  EXPECT_TRUE(begin != std::string::npos && end != std::string::npos) << from;
  const std::string part = all.substr(begin, end - begin);
  const std::regex row("\\| ([0-9]+) \\| ([a-z0-9\\[\\]]+) \\| `([A-Za-z]+)` \\|");
  std::vector<Row> rows;
  for (std::sregex_iterator i(part.begin(), part.end(), row), last; i != last; ++i) rows.push_back({size_t(std::stoul((*i)[1])), bytesOf.at((*i)[2]), (*i)[3]});
  return rows;
}

// That rows have the fields at these offsets, one behind the other, and end there.
void expectRows(const std::vector<Row>& rows, const std::map<std::string, size_t>& offsetOf, size_t begin, size_t size)
{
  size_t end = begin;
  for (const Row& row : rows) {
    EXPECT_EQ(row.offset, end) << row.field;
    ASSERT_EQ(offsetOf.count(row.field), 1u) << row.field;
    EXPECT_EQ(row.offset, offsetOf.at(row.field)) << row.field;
    end = row.offset + row.bytes;
  }
  EXPECT_EQ(rows.size(), offsetOf.size());
  EXPECT_EQ(end, size);
}

TEST(VertFormat, TheHeaderIsThatOfThePage)
{
  expectRows(rowsOf("## Header", "A **coordinate**"), {
    {"origin", offsetof(VertHeader, origin)}, {"reach", offsetof(VertHeader, reach)}, {"surface", offsetof(VertHeader, surface)},
    {"primID", offsetof(VertHeader, primID)}, {"region", offsetof(VertHeader, region)}, {"patchQuads", offsetof(VertHeader, patchQuads)},
    {"corners", offsetof(VertHeader, corners)}, {"boxForm", offsetof(VertHeader, boxForm)}, {"word", offsetof(VertHeader, word)}}, 0, vertHeaderBytes);
  expectRows(rowsOf("## Edges", "## Numbers"), {{"edges", vertHeaderBytes}}, vertHeaderBytes, vertHeaderBytes + vertEdgesBytes);
  expectRows(rowsOf("## Numbers", "The form, in"), {{"numbers", vertHeaderBytes}}, vertHeaderBytes, vertHeaderBytes + vertEdgesBytes);
  EXPECT_EQ(numbersOf("Header, # bytes"), Numbers{vertHeaderBytes});
  EXPECT_EQ(numbersOf("Edges, # bytes"), Numbers{vertEdgesBytes});
  EXPECT_EQ(numbersOf("Numbers, # bytes"), Numbers{sizeof(VertNumbers)});
}

TEST(VertFormat, MotionIsThatOfThePage)
{
  expectRows(rowsOf("## Motion", "A later step begins"), {
    {"begin", offsetof(VertMotion, begin)}, {"end", offsetof(VertMotion, end)}, {"numSteps", offsetof(VertMotion, numSteps)}, {"steps", offsetof(VertMotion, steps)}}, 0, vertMotionBytes);
  expectRows(rowsOf("A later step begins", "**Boxes** belong to segments"), {
    {"origin", offsetof(VertStep, origin)}, {"boxForm", offsetof(VertStep, boxForm)}, {"word", offsetof(VertStep, word)}, {"corners", offsetof(VertStep, corners)},
    {"turned", offsetof(VertStep, turned)}, {"turn", offsetof(VertStep, turn)}, {"reach", offsetof(VertStep, reach)}, {"endReach", offsetof(VertStep, endReach)}}, 0, vertStepBytes);
  EXPECT_EQ(numbersOf("of the segment that begins with the step; #: the step is raw; #: the first cell is turned; #: groups have the upper # bits of words; #: it has margins, "
                      "as all but the last have; #-#: the step of `reach` is #^this"), (Numbers{24, 25, 26, 8, 27, 28, 31, 2}));
  EXPECT_TRUE(isRaw(1u << 24) && isFirstCellTurned(1u << 25) && hasUpperBits(1u << 26) && hasMargins(1u << 27));
  EXPECT_EQ(beginReachStep(5u << 28), 32u);
  EXPECT_EQ(numbersOf("bits #-#: groups that are turned; #-#: the matrix's scale q; #-#: the step of `endReach` is #^this; #: #; #-#: the matrix's last entry"),
            (Numbers{0, 15, 16, 18, 19, 22, 2, 23, 0, 24, 31}));
  EXPECT_TRUE(isTurned(1u << 9, 9) && !isTurned(~(1u << 9), 9));
  EXPECT_EQ(endReachStep(5u << 19), 32u);
  VertStep step = {};
  step.turned = 3u << 16 | uint32_t(uint8_t(-100)) << 24;
  for (int i = 0; i < 8; i++) ((int8_t*)step.turn)[i] = int8_t(11*i - 40);
  for (int i = 0; i < 9; i++) EXPECT_EQ(turnEntry(step, uint32_t(i)), i < 8 ? 11*i - 40 : -100);

  const Numbers formula = numbersOf("floor((M[a][0] r[0] + M[a][1] r[1] + M[a][2] r[2] + #^(#-q)) / #^(#-q))");
  ASSERT_EQ(formula.size(), 4u);
  for (uint32_t q = 0; q <= 6; q++)
    for (int x = -50; x <= 50; x++) {
      const double sum = 91.0*x - 17*3.0 + 5*x*x;
      EXPECT_EQ(turnedResidual(91, -17, 5, x, 3, x*x, turnShift(q << 16)), std::floor((sum + std::pow(formula[0], formula[1] - q))/std::pow(formula[2], formula[3] - q)));
    }
  VertMotion motion = {0.25f, 0.75f, 5, 0};
  EXPECT_TRUE(isThere(motion, 0.25f) && isThere(motion, 0.75f) && !isThere(motion, 0.2f) && !isThere(motion, 0.8f));
  EXPECT_EQ(timeInMotion(motion, 0.5f).segment, 2u);
  EXPECT_EQ(timeInMotion(motion, 0.75f).segment, 3u);
  EXPECT_EQ(timeInMotion(motion, 0.75f).fraction, 1.0f);
  EXPECT_EQ(timeInMotion(motion, 0.4375f).fraction, 0.5f);
}

// Each field of a word in the bits that its row names: `field` has the value of all ones there, others none.
void expectFields(const Numbers& bits, const std::function<uint32_t(size_t field, uint32_t ones)>& wordOf)
{
  for (size_t field = 0; 2*field < bits.size(); field++) {
    const uint32_t first = uint32_t(bits[2*field]), count = uint32_t(bits[2*field + 1]) - first + 1, ones = (1u << count) - 1;
    EXPECT_EQ(wordOf(field, ones), ones << first) << "field " << field;
  }
}

TEST(VertFormat, FieldsAreWhereThePageSays)
{
  const Numbers place = numbersOf("bits #-#: w - 1; #-#: h - 1; #-# and #-#: the block's first quad in the patch along u and v, in blocks of # quads");
  ASSERT_EQ(place.size(), 9u);
  EXPECT_EQ(place[8], vertBlockQuads);
  expectFields(Numbers(place.begin(), place.end() - 1), [](size_t field, uint32_t ones) {
    return vertRegion(1 + (field == 0)*ones, 1 + (field == 1)*ones, (field == 2)*ones*vertBlockQuads, (field == 3)*ones*vertBlockQuads);
  });
  const Numbers quads = numbersOf("quads of the patch along u and v, less 1: bits #-# and #-#");
  ASSERT_EQ(quads.size(), 4u);
  expectFields(quads, [](size_t field, uint32_t ones) { return vertPatch(1 + (field == 0)*ones, 1 + (field == 1)*ones); });
  const Numbers edges = numbersOf("bits #-#: the rate less 1 that its vertices have; #-#: of the first two, u and v of the face");
  ASSERT_EQ(edges.size(), 4u);
  expectFields(edges, [](size_t field, uint32_t ones) { return vertEdges(1 + (field == 0)*ones, 1, 1, 1, (field == 1)*ones, 0).low; });
  EXPECT_EQ(numbersOf("#: the block has edges; #: it has numbers, and not both; #: it moves"), (Numbers{29, 30, 31}));
  EXPECT_TRUE(isMoving(1u << 31) && !isMoving(~(1u << 31)));
  EXPECT_TRUE(hasEdges(1u << 29) && !hasEdges(~(1u << 29)));
  EXPECT_TRUE(hasNumbers(1u << 30) && !hasNumbers(~(1u << 30)));
}

TEST(VertFormat, NumbersAreThoseOfThePage)
{
  EXPECT_EQ(numbersOf("The form, in `patchQuads`: bits #-#: the pattern; #: the mesh is of triangles; #: the first triangle has no second one"), (Numbers{0, 1, 2, 3}));
  EXPECT_TRUE(isOfTriangles(1u << 2) && !isOfTriangles(~(1u << 2)) && isOneTriangle(1u << 3) && !isOneTriangle(~(1u << 3)));
  EXPECT_EQ(numbersOf("#-# and #-#: by how many corners the first and the second triangle are turned; #-#: C; #-#: 0"), (Numbers{4, 5, 6, 7, 8, 15, 16, 31}));
  EXPECT_EQ(formOfTurns(3, 0), 3u << 4);
  EXPECT_EQ(formOfTurns(0, 3), 3u << 6);
  EXPECT_EQ(turnOfTriangle(2u << 4, false), 2u);
  EXPECT_EQ(turnOfTriangle(2u << 6, true), 2u);

  // rows: X x + Y y
  EXPECT_EQ(patternNumber(numbersInRows, VertNumbers{3u, ~0u}, 5, 4), 11u);
  // recursive: C, and bytes of X and Y for bits of x and y, twice for triangles
  const VertNumbers bytes = {0x40100401u, 0xC0300C03u};
  EXPECT_EQ(patternNumber(numbersRecursive | 0xFFu << 8, bytes, 5, 8), 0xFFu ^ 0x01u ^ 0x10u ^ 0xC0u);
  EXPECT_EQ(patternNumber(numbersRecursive | numbersOfTriangles, bytes, 2, 1), 2*(0x04u ^ 0x03u));
  // table: bits of it
  alignas(16) uint8_t block[256] = {};
  VertHeader& header = *(VertHeader*)block;
  header.primID = 1000;
  header.region = vertRegion(3, 2, 0, 0);
  header.boxForm = 1u << 30;
  header.patchQuads = numbersInTable;
  const VertNumbers table = {128, 11};
  std::memcpy(&header + 1, &table, sizeof(table));
  const uint32_t bit = 11*(3*1 + 2); // of quad (2,1)
  for (uint32_t b = 0; b < 11; b++)
    if ((1234u >> b) & 1) block[128 + (bit + b)/8] |= uint8_t(1u << ((bit + b) % 8));
  EXPECT_EQ(numberOfQuad(&header, 2, 1), 2234u);
  EXPECT_EQ(numberOfQuad(&header, 1, 1), 1000u);
  EXPECT_EQ(numberOfQuad(&header, 3, 15), 2234u) << "the last quad's, of one outside";

  // (w1,w2), (w2,w0) or (w0,w1)
  const float a = 0.25f, b = 0.125f, w[] = {1 - a - b, a, b}, second[] = {1 - (1 - a) - (1 - b), 1 - a, 1 - b};
  for (uint32_t turn = 0; turn < 3; turn++) {
    const OwnParameters p = ownParameters(numbersOfTriangles | formOfTurns(turn, 0), false, a, b);
    EXPECT_EQ(p.u, w[(1 + turn) % 3]);
    EXPECT_EQ(p.v, w[(2 + turn) % 3]);
    const OwnParameters q = ownParameters(numbersOfTriangles | formOfTurns(0, turn), true, 1 - a, 1 - b);
    EXPECT_EQ(q.u, w[(1 + turn) % 3]);
    EXPECT_EQ(q.v, w[(2 + turn) % 3]);
  }
  EXPECT_LT(second[0], 0) << "outside of the second triangle w0 is cut off at 0";
  EXPECT_EQ(ownParameters(numbersOfTriangles | formOfTurns(0, 2), true, a, b).u, 0);
  const OwnParameters own = ownParameters(0, true, a, b);
  EXPECT_EQ(own.u, a);
  EXPECT_EQ(own.v, b);
  EXPECT_EQ(primitiveOfNumber(0, 6, true), 6u);
  EXPECT_EQ(primitiveOfNumber(numbersOfTriangles, 6, true), 7u);
  EXPECT_EQ(primitiveOfNumber(numbersOfTriangles, 6, false), 6u);
  EXPECT_EQ(primitiveOfNumber(numbersOfTriangles | numbersOfOneTriangle, 6, true), 6u);
}

} // namespace
} // namespace cbvh::test
