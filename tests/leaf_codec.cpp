// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Leaves of cLEAF: what is stored bounds the quad, and says so when it cannot. */

#include "kernels/cbvh/block_encoder.h"
#include "test_random.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace cbvh {
namespace {

using namespace embree::cbvh;

NodeBox randomBox(Random& random)
{
  NodeBox box;
  for (int axis = 0; axis < 3; axis++) {
    box.extent[axis] = float(random.magnitude(1.0/256, 1.0));
    box.lower[axis] = float(random.uniform(0, 1 - box.extent[axis]));
  }
  return box;
}

// Vertices in the box; the first kinds are graphs over it, the others are not.
enum Shape { REGULAR, JITTERED, STEEP, FOLDED, ANYWHERE, COLLAPSED, VERTICAL, SHAPES };

void makeQuad(Random& random, Shape shape, const NodeBox& box, double quad[4][3])
{
  const double slopeX = random.uniform(-1, 1), slopeY = random.uniform(-1, 1);
  for (int i = 0; i < 4; i++) {
    double p[3] = {double(i & 1), double(i >> 1), random.uniform()};
    switch (shape) {
    case REGULAR: break;
    case JITTERED:
      for (int k = 0; k < 2; k++) p[k] = std::fabs(p[k] - 0.3*random.uniform());
      p[2] = 0.5 + 0.25*slopeX*(p[0] - 0.5) + 0.25*slopeY*(p[1] - 0.5) + 0.1*random.uniform();
      break;
    case STEEP: p[2] = 0.5*(p[0] + p[1]); break;
    case FOLDED: p[0] = i == 1 ? 0 : p[0]; break;
    case COLLAPSED: p[0] = p[1] = 0.5; break;
    case VERTICAL: p[0] = 0.5; break;
    default: p[0] = random.uniform(); p[1] = random.uniform(); break;
    }
    for (int k = 0; k < 3; k++) quad[i][k] = box.lower[k] + box.extent[k]*std::min(1.0, std::max(0.0, p[k]));
  }
}

// The stored interval at a point of the box, in double.
void intervalAt(const NodeBox& box, float zScale, uint16_t leaf, double u, double v, double& lower, double& upper)
{
  const double size = double(zScale)*box.extent[2]/16, base = box.lower[2] - 0.5*(double(zScale) - 1)*box.extent[2];
  double q[4];
  for (int c = 0; c < 4; c++) q[c] = base + leafHeight(leaf, c)*size;
  lower = (1 - v)*((1 - u)*q[0] + u*q[1]) + v*((1 - u)*q[2] + u*q[3]);
  upper = lower + size;
}

// The encoder's slack, and what its float arithmetic on numbers up to 4 rounds.
constexpr double tolerance = containmentSlack + 0x1p-20;

TEST(LeafCodec, IntervalContainsTheVerticesOrTheLeafIsSolid)
{
  Random random(11);
  unsigned heights[SHAPES] = {}, solid[SHAPES] = {};
  for (int shape = 0; shape < SHAPES; shape++)
    for (int i = 0; i < 20000; i++) {
      const NodeBox box = randomBox(random);
      const float zScale = float(random.uniform(1, decodeZScale(zScaleCodes - 1)));
      double quad[4][3];
      makeQuad(random, Shape(shape), box, quad);
      const uint16_t leaf = encodeLeaf(box, zScale, quad, extrapolateQuad(box, quad));
      ASSERT_NE(leaf, emptyLeaf);
      (leaf == solidLeaf ? solid : heights)[shape]++;
      if (leaf == solidLeaf) continue;
      for (int c = 0; c < 4; c++) {
        double lower, upper;
        intervalAt(box, zScale, leaf, (quad[c][0] - box.lower[0])/box.extent[0], (quad[c][1] - box.lower[1])/box.extent[1], lower, upper);
        ASSERT_GE(quad[c][2], lower - tolerance) << "shape " << shape << ", quad " << i << ", corner " << c;
        ASSERT_LE(quad[c][2], upper + tolerance) << "shape " << shape << ", quad " << i << ", corner " << c;
      }
    }
  // neither answer may be the only one
  EXPECT_GT(heights[REGULAR], solid[REGULAR]);
  EXPECT_GT(heights[JITTERED], solid[JITTERED]);
  EXPECT_GT(solid[VERTICAL], 0u);
  EXPECT_GT(solid[ANYWHERE], 0u);
}

TEST(LeafCodec, CornerHeightsComeBackWithinABin)
{
  Random random(12);
  for (int i = 0; i < 20000; i++) {
    const NodeBox box = randomBox(random);
    double quad[4][3];
    makeQuad(random, REGULAR, box, quad);
    const CornerHeights h = extrapolateQuad(box, quad);
    const float zScale = std::max(1.0f, float(requiredZScale(box, h)*1.0001));
    ASSERT_LE(zScale, 1.001f) << "vertices at the corners of the box need no larger range";
    const uint16_t leaf = encodeLeaf(box, zScale, quad, h);
    if (leaf == solidLeaf) continue; // the two codes that are taken
    const LeafBins bins(box, zScale);
    for (int c = 0; c < 4; c++) {
      ASSERT_NEAR(h.z[c], quad[c][2], 1e-9) << "extrapolation to where the vertex already is";
      const double lower = double(bins.base) + leafHeight(leaf, c)*double(bins.size);
      ASSERT_GE(quad[c][2], lower - tolerance);
      ASSERT_LE(quad[c][2], lower + double(bins.size) + tolerance);
    }
  }
}

TEST(LeafCodec, EveryHeightIsReachedAndReadBack)
{
  const NodeBox box = NodeBox::root();
  for (int corner = 0; corner < 4; corner++)
    for (int bin = 0; bin < heightBins; bin++) {
      double quad[4][3];
      for (int c = 0; c < 4; c++) {
        quad[c][0] = c & 1;
        quad[c][1] = c >> 1;
        quad[c][2] = ((c == corner ? bin : 3) + 0.5)/heightBins;
      }
      const uint16_t leaf = encodeLeaf(box, 1.0f, quad, extrapolateQuad(box, quad));
      for (int c = 0; c < 4; c++) EXPECT_EQ(leafHeight(leaf, c), c == corner ? bin : 3);
    }
}

// The two special codes are heights (15,15,15,15) and (14,15,15,15).
TEST(LeafCodec, HeightsThatReadAsSpecialCodesBecomeSolid)
{
  for (int low : {14, 15}) {
    double quad[4][3];
    for (int c = 0; c < 4; c++) {
      quad[c][0] = c & 1;
      quad[c][1] = c >> 1;
      quad[c][2] = ((c == 0 ? low : 15) + 0.5)/heightBins;
    }
    EXPECT_EQ(encodeLeaf(NodeBox::root(), 1.0f, quad, extrapolateQuad(NodeBox::root(), quad)), solidLeaf);
  }
}

TEST(LeafCodec, QuadsWithAVertexThatIsNotFiniteAreEmptyAndNoOthers)
{
  Random random(13);
  const float bad[3] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
  for (uint32_t height = 0; height <= 4; height++)
    for (int repeat = 0; repeat < 20; repeat++) {
      const uint32_t n = 1u << height, width = n + 1;
      std::vector<float> vertices(3*width*width);
      for (uint32_t y = 0; y < width; y++)
        for (uint32_t x = 0; x < width; x++) {
          float* p = &vertices[3*(y*width + x)];
          p[0] = float(x); p[1] = float(y); p[2] = float(0.3*random.uniform());
        }
      float corners[4][3];
      for (int c = 0; c < 4; c++)
        std::copy_n(&vertices[3*((c >> 1)*n*width + (c & 1)*n)], 3, corners[c]);
      for (int i = 0; i < repeat % 5; i++) vertices[random.below(3*width*width)] = bad[random.below(3)];

      std::vector<Double3> scratch(BlockEncoder::scratchBytes(height)/sizeof(Double3) + 2), memory(BlockLayout(Kind::LEAF, height).bytes/sizeof(Double3) + 2);
      auto align = [](void* p) { return (void*)((uintptr_t(p) + 15) & ~uintptr_t(15)); };
      BlockEncoder encoder(Kind::LEAF, height, (const float(*)[3])vertices.data(), align(scratch.data()));
      auto isBad = [&](uint32_t x, uint32_t y) {
        for (uint32_t c = 0; c < 4; c++)
          for (int k = 0; k < 3; k++)
            if (!std::isfinite(vertices[3*((y + (c >> 1))*width + x + (c & 1)) + k])) return true;
        return false;
      };
      if (!encoder.fit(corners)) continue; // all are bad
      Block* block = (Block*)align(memory.data());
      BlockStatistics stats;
      encoder.encode(block, 0, 0, stats);
      uint32_t count = 0;
      for (uint32_t m = 0; m < n*n; m++) {
        const bool expected = isBad(mortonX(m), mortonY(m));
        count += expected;
        ASSERT_EQ(((const uint16_t*)block->leaves())[m] == emptyLeaf, expected) << "height " << height << ", quad " << m;
      }
      EXPECT_EQ(stats.invalidQuads, count);
    }
}

} // namespace
} // namespace cbvh
