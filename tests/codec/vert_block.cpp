// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Blocks of cVERT lose nothing: random vertices on random lattices, of every size of block, are
 * the same floats after encoding and scalar decoding, and boxes contain their groups in the
 * floats of the traversal. */

#include "kernels/cbvh/surface/lattice.h"
#include "kernels/cbvh/vert/encoder.h"
#include "kernels/cbvh/vert/scalar_block.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <sstream>
#include <vector>

namespace cbvh::test {
namespace {

using namespace embree::cbvh;

constexpr uint32_t seed = 71;

// A block's room; memory behind it is not the encoder's.
struct Encoded
{
  alignas(16) uint8_t bytes[VertEncoder::maxBytes];
  size_t size = 0;
  VertStatistics statistics;

  Encoded(VertEncoder& encoder, const VertPlacement& at, float spacing) { size = encoder.encode(at, spacing, bytes, statistics); }
  const VertHeader* block() const { return (const VertHeader*)bytes; }
};

// A block that is all of its patch.
VertPlacement whole(uint32_t quadsX, uint32_t quadsY) { return {vertRegion(quadsX, quadsY, 0, 0), vertPatch(quadsX, quadsY)}; }

// The same with edges behind its header.
VertPlacement withEdges(uint32_t quadsX, uint32_t quadsY) { return {vertRegion(quadsX, quadsY, 0, 0), vertPatch(quadsX, quadsY), vertEdges(quadsX, quadsY, 1, 1, 1, 5)}; }

// A sheet of that many quads on a lattice: a plane, a bend and noise in steps of the lattice.
struct Sheet
{
  uint32_t quadsX, quadsY;
  float spacing;
  double origin[3];
  std::vector<std::array<float, 3>> vertices;

  Sheet(Random& random, uint32_t quadsX, uint32_t quadsY, double roughness) : quadsX(quadsX), quadsY(quadsY)
  {
    spacing = std::ldexp(1.0f, int(random.below(60)) - 30);
    double axis[3][3];
    for (int k = 0; k < 3; k++) {
      origin[k] = std::floor(random.uniform(-4e6, 4e6));
      for (double* a : {axis[0], axis[1], axis[2]}) a[k] = random.uniform(-40, 40);
    }
    for (uint32_t y = 0; y <= quadsY; y++)
      for (uint32_t x = 0; x <= quadsX; x++) {
        const double h = roughness*random.normal() + 0.02*(double(x)*x - double(y)*x);
        std::array<float, 3> v;
        // 40 is not along a normal any more: residuals of all axes are large
        const double sideways = roughness == 40 ? 1000 : 0;
        for (int k = 0; k < 3; k++)
          v[k] = float((origin[k] + std::floor(x*axis[0][k] + y*axis[1][k] + (sideways > 0 ? sideways*random.normal() : h*axis[2][k])))*spacing);
        vertices.push_back(v);
      }
  }

  void fill(VertEncoder& encoder) const
  {
    for (size_t i = 0; i < vertices.size(); i++) std::copy(vertices[i].begin(), vertices[i].end(), encoder.vertices[i]);
  }
};

// From the block's origin, exactly.
float shearedCoordinate(const VertHeader* block, const float* p)
{
  const int m = shearedAxis(block->boxForm), a = (m + 1) % 3, b = (m + 2) % 3;
  return float(double(p[m]) - block->origin[m] + shearSlope(block->boxForm, 1)/16.0*(double(p[a]) - block->origin[a])
             + shearSlope(block->boxForm, 2)/16.0*(double(p[b]) - block->origin[b]));
}

bool sameFloat(float a, float b) { return std::memcmp(&a, &b, sizeof(a)) == 0 || (a == 0 && b == 0); }

TEST(VertBlock, VerticesAreTheSameFloats)
{
  Random random(seed);
  auto encoder = std::make_unique<VertEncoder>();
  size_t packed = 0, raw = 0, byAxis = 0;
  for (int i = 0; i < 4000; i++) {
    const Sheet sheet(random, 1 + random.below(16), 1 + random.below(16), std::vector<double>{0, 0.05, 0.5, 5, 40}[i % 5]);
    sheet.fill(*encoder);
    const Encoded encoded(*encoder, i % 4 == 0 ? withEdges(sheet.quadsX, sheet.quadsY) : whole(sheet.quadsX, sheet.quadsY), sheet.spacing);
    ASSERT_GT(encoded.size, sizeof(VertHeader));
    const auto decoded = std::make_unique<ScalarVertBlock>(encoded.block());
    ASSERT_EQ(decoded->quadsX, sheet.quadsX);
    ASSERT_EQ(decoded->quadsY, sheet.quadsY);
    for (size_t v = 0; v < sheet.vertices.size(); v++)
      for (int k = 0; k < 3; k++)
        ASSERT_TRUE(sameFloat(decoded->vertices[v][k], sheet.vertices[v][k])) << "sheet " << i << ", vertex " << v << ", axis " << k;
    ASSERT_EQ(encoded.statistics.raw, isRaw(encoded.block()->boxForm));
    (encoded.statistics.raw ? raw : packed)++;
    byAxis += !encoded.statistics.raw && isByAxis(encoded.block()->word);
    if (!encoded.statistics.raw) {
      ASSERT_EQ((size_t(decoded->end - encoded.bytes) + 3) & ~size_t(3), encoded.size) << "bytes that nobody reads";
    }
  }
  EXPECT_GT(packed, 3000u);
  EXPECT_GT(packed + raw, 3999u);
  EXPECT_GT(byAxis, 300u);
}

TEST(VertBlock, AFlatPartTakesNoFields)
{
  auto encoder = std::make_unique<VertEncoder>();
  for (uint32_t y = 0; y <= 16; y++)
    for (uint32_t x = 0; x <= 16; x++) {
      float* v = encoder->vertices[17*y + x];
      v[0] = 32.0f*float(x); v[1] = 32.0f*float(y); v[2] = 16.0f*float(x) - 48.0f*float(y);
    }
  const Encoded encoded(*encoder, whole(16, 16), 1.0f);
  EXPECT_EQ(encoded.statistics.fieldBytes, 0u);
  EXPECT_EQ(encoded.size, vertLayout(encoded.block()->region, encoded.block()->boxForm).cell);
}

TEST(VertBlock, BoxesContainTheirGroups)
{
  Random random(seed + 1);
  auto encoder = std::make_unique<VertEncoder>();
  size_t loose = 0, planes = 0, sheared = 0;
  for (int i = 0; i < 2000; i++) {
    const Sheet sheet(random, 1 + random.below(16), 1 + random.below(16), 0.5);
    sheet.fill(*encoder);
    const bool hole = i % 5 == 0;
    if (hole) encoder->vertices[0][i % 3] = i % 2 ? NAN : INFINITY;
    const VertPlacement place = i % 4 == 0 ? withEdges(sheet.quadsX, sheet.quadsY) : whole(sheet.quadsX, sheet.quadsY);
    const Encoded encoded(*encoder, place, sheet.spacing);
    const VertLayout layout = vertLayout(place.region, place.form());
    const auto decoded = std::make_unique<ScalarVertBlock>(encoded.block());
    for (uint32_t g = 0; g < layout.groups; g++) {
      float lower[3], upper[3];
      decoded->groupBox(g, lower, upper);
      const uint32_t x0 = groupQuads*(g % layout.groupsX), y0 = groupQuads*(g/layout.groupsX);
      for (int k = 0; k < 3; k++) {
        const bool isSheared = !encoded.statistics.raw && k == shearedAxis(encoded.block()->boxForm);
        if (isSheared) sheared += shearSlope(encoded.block()->boxForm, 1) != 0;
        float least = INFINITY, greatest = -INFINITY;
        for (uint32_t y = y0; y <= std::min(y0 + groupQuads, sheet.quadsY); y++)
          for (uint32_t x = x0; x <= std::min(x0 + groupQuads, sheet.quadsX); x++) {
            if (hole && x + y == 0) continue;
            const float v = isSheared ? shearedCoordinate(encoded.block(), decoded->vertex(x, y)) : decoded->vertex(x, y)[k];
            ASSERT_LE(lower[k], v) << "sheet " << i << ", group " << g;
            ASSERT_GE(upper[k], v) << "sheet " << i << ", group " << g;
            least = std::min(least, v); greatest = std::max(greatest, v);
          }
        if (encoded.statistics.raw) { // exact
          ASSERT_EQ(lower[k], least) << "sheet " << i << ", group " << g;
          ASSERT_EQ(upper[k], greatest) << "sheet " << i << ", group " << g;
          continue;
        }
        const float step = vertSpacing(encoded.block()->word)*float(1u << marginShift(encoded.block()->boxForm, k));
        planes += 2;
        // margins are whole coordinates, sheared ones sixteenths
        const float most = isSheared ? step + vertSpacing(encoded.block()->word) : step;
        loose += (least - lower[k] >= most) + (upper[k] - greatest >= most);
      }
    }
  }
  EXPECT_EQ(loose, 0u) << "of " << planes << " planes are more than a step off";
  EXPECT_GT(sheared, 1000u);
}

TEST(VertBlock, ReachContainsTheBlock)
{
  Random random(seed + 3);
  auto encoder = std::make_unique<VertEncoder>();
  size_t blocks = 0, loose = 0;
  for (int i = 0; i < 2000; i++) {
    const Sheet sheet(random, 1 + random.below(16), 1 + random.below(16), std::vector<double>{0, 0.05, 0.5, 5}[i % 4]);
    sheet.fill(*encoder);
    const Encoded encoded(*encoder, whole(sheet.quadsX, sheet.quadsY), sheet.spacing);
    if (encoded.statistics.raw) continue;
    blocks++;
    const VertHeader* block = encoded.block();
    const auto decoded = std::make_unique<ScalarVertBlock>(block);
    const float step = float(reachStep(block->boxForm))*vertSpacing(block->word);
    const int m = shearedAxis(block->boxForm);
    float least[3] = {INFINITY, INFINITY, INFINITY}, greatest[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (uint32_t v = 0; v < (sheet.quadsX + 1)*(sheet.quadsY + 1); v++) {
      const float* p = decoded->vertices[v];
      const float x[3] = {p[(m + 1) % 3] - block->origin[(m + 1) % 3], p[(m + 2) % 3] - block->origin[(m + 2) % 3], shearedCoordinate(block, p)};
      for (int k = 0; k < 3; k++) { least[k] = std::min(least[k], x[k]); greatest[k] = std::max(greatest[k], x[k]); }
    }
    ASSERT_EQ(least[0], 0);
    ASSERT_EQ(least[1], 0);
    for (int k = 0; k < 3; k++) {
      const float upper = float(reachOf(block->reach, k < 2 ? k : 3))*step, lower = k < 2 ? 0 : float(reachOf(block->reach, 2))*step;
      ASSERT_LE(lower, least[k]);
      ASSERT_GE(upper, greatest[k]);
      loose += upper - greatest[k] > 1.0625f*step || least[k] - lower > 1.0625f*step; // sheared coordinates are sixteenths
    }
  }
  EXPECT_GT(blocks, 1000u);
  EXPECT_EQ(loose, 0u);
}

TEST(VertBlock, VerticesThatAreNotFiniteAreRawAndNaN)
{
  Random random(seed + 2);
  auto encoder = std::make_unique<VertEncoder>();
  const Sheet sheet(random, 16, 16, 0.5);
  for (float bad : {NAN, INFINITY, -INFINITY, 3e18f}) {
    sheet.fill(*encoder);
    encoder->vertices[17*5 + 5][1] = bad;
    const Encoded encoded(*encoder, whole(16, 16), sheet.spacing);
    EXPECT_TRUE(encoded.statistics.raw);
    EXPECT_EQ(encoded.statistics.invalidQuads, 4u);
    const auto decoded = std::make_unique<ScalarVertBlock>(encoded.block());
    for (int k = 0; k < 3; k++) EXPECT_TRUE(std::isnan(decoded->vertex(5, 5)[k]));
    for (int k = 0; k < 3; k++) EXPECT_EQ(decoded->vertex(6, 5)[k], sheet.vertices[17*5 + 6][k]);
  }
  for (auto& v : encoder->vertices) v[0] = NAN;
  EXPECT_EQ(Encoded(*encoder, whole(16, 16), 1).size, 0u) << "a block without a vertex";
}

TEST(VertBlock, WhatIsOffTheLatticeIsRaw)
{
  Random random(seed + 3);
  auto encoder = std::make_unique<VertEncoder>();
  const Sheet sheet(random, 8, 8, 0.5);
  sheet.fill(*encoder);
  encoder->vertices[40][2] += 0.5f*sheet.spacing;
  if (encoder->vertices[40][2] == sheet.vertices[40][2]) encoder->vertices[40][2] = std::nextafter(sheet.vertices[40][2], INFINITY);
  const Encoded encoded(*encoder, whole(8, 8), sheet.spacing);
  const auto decoded = std::make_unique<ScalarVertBlock>(encoded.block());
  EXPECT_EQ(decoded->vertices[40][2], encoder->vertices[40][2]);
}

TEST(VertBlock, BlocksOf2To14StepsAreRaw)
{
  auto encoder = std::make_unique<VertEncoder>();
  for (int width : {16383, 16384}) {
    for (int v = 0; v < 4; v++) {
      encoder->vertices[v][0] = v & 1 ? float(width) : 0;
      encoder->vertices[v][1] = v & 2 ? 8.0f : 0;
      encoder->vertices[v][2] = 0;
    }
    const Encoded encoded(*encoder, whole(1, 1), 1);
    EXPECT_EQ(encoded.statistics.raw, width == 16384) << width;
  }
}

// Rows "| offset | `bytes` | meaning |" of the page's last section.
TEST(VertBlock, TheAnnotatedBlockIsWhatTheEncoderWrites)
{
  std::ifstream file(FORMATS "/block_example.md");
  std::vector<int> annotated;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.compare(0, 1, "#") == 0) inside = line == "## Annotated block";
    unsigned offset;
    if (!inside || std::sscanf(line.c_str(), "| %u | `", &offset) != 1) continue;
    EXPECT_EQ(offset, annotated.size()) << line;
    const size_t begin = line.find('`') + 1;
    std::istringstream row(line.substr(begin, line.find('`', begin) - begin));
    for (unsigned byte; row >> std::hex >> byte;) annotated.push_back(int(byte));
  }
  auto encoder = std::make_unique<VertEncoder>();
  for (int j = 0; j <= 2; j++)
    for (int i = 0; i <= 5; i++) {
      float* v = encoder->vertices[6*j + i];
      v[0] = float(100 + 8*i); v[1] = float(8*j); v[2] = float(i*i - (i == 1 && j == 1 ? 12 : 0));
    }
  Encoded encoded(*encoder, {vertRegion(5, 2, 16, 0), vertPatch(21, 2), vertEdges(21, 2, 7, 2, 0, 0)}, 1);
  VertHeader* block = (VertHeader*)encoded.bytes;
  block->surface = 3;
  block->primID = 5;
  EXPECT_EQ(std::vector<int>(encoded.bytes, encoded.bytes + encoded.size), annotated);
}

TEST(VertCell, FieldsOfVerticesAreAllButTheCorners)
{
  std::vector<int> seen(cellFields, 0);
  for (int j = 0; j < 5; j++)
    for (int i = 0; i < 5; i++) {
      const int f = cellField(i, j);
      if (i % 4 == 0 && j % 4 == 0) EXPECT_EQ(f, -1);
      else { ASSERT_GE(f, 0); ASSERT_LT(f, cellFields); seen[f]++; }
    }
  for (int n : seen) EXPECT_EQ(n, 1);
}

TEST(VertCell, PredictionsAreBilinearAndInterpolateCorners)
{
  Random random(seed + 4);
  for (int n = 0; n < 20000; n++) {
    int c[4];
    for (int& x : c) x = int(random.below(maxExtent));
    const int quads = 1 + int(random.below(4)), i = int(random.below(5)), j = int(random.below(5));
    const int wx = cellWeight(i, 1, quads), wy = cellWeight(j, 1, quads);
    if (quads != 3) { EXPECT_EQ(wx, 16*std::min(i, quads)/quads); }
    const double x = wx/16.0, y = wy/16.0;
    const double exact = c[0]*(1-x)*(1-y) + c[1]*x*(1-y) + c[2]*(1-x)*y + c[3]*x*y;
    EXPECT_EQ(cellPrediction(c[0], c[1], c[2], c[3], wx, wy), int(std::floor(exact + 0.5)));
    EXPECT_EQ(cellPrediction(c[0], c[1], c[2], c[3], 16, 16), c[3]);
  }
}

TEST(VertCell, SlopesAreSixteenthsRoundedToTheNearest)
{
  for (int slope = -maxSlope; slope <= maxSlope; slope++)
    for (int main = -300; main <= 300; main++) EXPECT_EQ(slopeResidual(slope, main), int(std::floor(slope*main/16.0 + 0.5)));
}

// As stitch() of upstream's tessellation.h, whose vertices GRID's are.
// The spacing asked for or a finer one, but coordinates of a face fit into 23 bits.
TEST(WorldLattice, ExponentsAreThoseAskedForUnlessCoordinatesHaveTooManyBits)
{
  EXPECT_EQ(latticeExponent(0.25, 1), -2);
  EXPECT_EQ(latticeExponent(0.3, 1), -2);
  EXPECT_EQ(latticeExponent(1e-9, 1000), 10 - maxCoordinateBits);
  EXPECT_EQ(latticeExponent(1e-9, 1024), 11 - maxCoordinateBits);
  EXPECT_EQ(latticeExponent(0, 1000), 10 - maxCoordinateBits);
  EXPECT_EQ(latticeExponent(0, 0), minLatticeExponent);
  EXPECT_EQ(latticeExponent(1e38, 1), maxLatticeExponent);
}

TEST(VertParameters, StitchedVerticesAreThoseOfEmbree)
{
  for (uint32_t quads = 1; quads <= 256; quads += quads < 20 ? 1 : 17)
    for (uint32_t rate = 1; rate <= quads; rate++) {
      EXPECT_EQ(stitchedVertex(0, quads, rate), 0u);
      EXPECT_EQ(stitchedVertex(quads, quads, rate), rate);
      for (uint32_t x = 0; x <= quads; x++) {
        const double exact = double(x)*rate/quads;
        ASSERT_EQ(stitchedVertex(x, quads, rate), uint32_t(std::floor(exact + 0.5*rate/quads)));
        if (rate == quads) { ASSERT_EQ(vertParameter<float>(x, quads, rate), float(x)/float(quads)); }
      }
    }
}

TEST(VertHeader, FieldsOfPlaceAndEdgesAreApart)
{
  Random random(seed + 5);
  for (int n = 0; n < 1000; n++) {
    const uint32_t w = 1 + random.below(16), h = 1 + random.below(16), x = 16*random.below(4096), y = 16*random.below(4096), u = random.below(16), v = random.below(16);
    const uint32_t region = vertRegion(w, h, x, y);
    EXPECT_EQ(vertQuadsX(region), w); EXPECT_EQ(vertQuadsY(region), h);
    EXPECT_EQ(vertX(region), x); EXPECT_EQ(vertY(region), y);
    const uint32_t quadsX = 1 + random.below(65536), quadsY = 1 + random.below(65536);
    EXPECT_EQ(patchQuadsX(vertPatch(quadsX, quadsY)), quadsX);
    EXPECT_EQ(patchQuadsY(vertPatch(quadsX, quadsY)), quadsY);
    uint32_t rate[4];
    for (uint32_t& r : rate) r = 1 + random.below(maxVertRate);
    const VertEdges edges = vertEdges(rate[0], rate[1], rate[2], rate[3], u, v);
    for (int s = 0; s < 4; s++) EXPECT_EQ(vertRate(edges, s), rate[s]);
    EXPECT_EQ(vertCornerU(edges), u); EXPECT_EQ(vertCornerV(edges), v);
  }
}

} // namespace
} // namespace cbvh::test
