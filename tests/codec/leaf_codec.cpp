// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Leaves of cLEAF: what is stored bounds the quads' edges, and says so when it cannot. */

#include "kernels/cbvh/build/block_encoder.h"
#include "kernels/cbvh/codec/crossing.h"
#include "kernels/cbvh/codec/tree.h"
#include "support/random.h"

#include <algorithm>
#include <limits>
#include <vector>

namespace cbvh::test {
namespace {

using namespace embree::cbvh;

// The encoder's slack, and what float arithmetic on numbers up to 4 rounds.
constexpr double tolerance = containmentSlack + 0x1p-20;

// Lattices of vertices in the parent's box; the first kinds are graphs over it.
enum Shape { REGULAR, WAVY, JITTERED, STEEP, ROUGH, FOLDED, ANYWHERE, COLLAPSED, VERTICAL, SHAPES };

// rounding: how far from there a neighbouring face may have vertices, in parent extents.
void makeGroup(Random& random, Shape shape, const NodeBox& parent, QuadGroup& group, double rounding = 0)
{
  const double slopeX = random.uniform(-1, 1), slopeY = random.uniform(-1, 1), bend = random.uniform(-1, 1);
  for (int v = 0; v < 9; v++) {
    double x = 0.05 + 0.45*(v % 3), y = 0.05 + 0.45*(v / 3), z = 0.5 + 0.2*slopeX*(x - 0.5) + 0.2*slopeY*(y - 0.5) + 0.3*bend*(x - 0.5)*(y - 0.5);
    switch (shape) {
    case WAVY: z += 0.1*std::sin(7*x + 3*y + 6*bend); break;
    case JITTERED:
      x += random.uniform(-0.05, 0.05);
      y += random.uniform(-0.05, 0.05);
      z += 0.05*random.uniform();
      break;
    case STEEP: z = 0.1 + 0.4*(x + y); break;
    case ROUGH: z = random.uniform(0.2, 0.8); break;
    case FOLDED: if (v % 3 == 1) x = 0.97; break;
    case COLLAPSED: x = y = 0.5; break;
    case VERTICAL: z = x; x = 0.5; break;
    case ANYWHERE: x = random.uniform(); y = random.uniform(); z = random.uniform(); break;
    default: break;
    }
    const double p[3] = {x, y, z};
    for (int k = 0; k < 3; k++) group.vertices[v][k] = parent.lower[k] + parent.extent[k]*std::min(0.999, std::max(0.001, p[k]));
  }
  for (int k = 0; k < 3; k++) group.rounding[k] = rounding*parent.extent[k];
  for (int quad = 0; quad < 4; quad++) {
    ExactBox& box = group.boxes[quad] = ExactBox();
    for (int c = 0; c < 4; c++) box.extend(group.vertexOf(quad, c));
    for (int k = 0; k < 3; k++) {
      box.lower[k] -= group.rounding[k];
      box.upper[k] += group.rounding[k];
    }
  }
  for (auto& axis : group.border)
    for (bool& side : axis) side = random.chance(0.3);
}

NodeBox randomBox(Random& random)
{
  NodeBox box;
  for (int axis = 0; axis < 3; axis++) {
    box.extent[axis] = float(random.magnitude(1.0/64, 1.0));
    box.lower[axis] = float(random.uniform(0, 1 - box.extent[axis]));
  }
  return box;
}

// Distance of a leaf's surface from a point, up; false outside of its box.
bool surfaceAbove(const LeafPatch& leaf, const double p[3], double& distance, double position[2])
{
  for (int k = 0; k < 3; k++)
    if (p[k] < leaf.box.lower[k] - tolerance || p[k] > upperOf(leaf.box, k) + tolerance) return false;
  for (int k = 0; k < 2; k++)
    position[k] = std::min(1.0, std::max(0.0, (p[k] - leaf.box.lower[k])/leaf.box.extent[k]));
  distance = patchZ(leaf, position[0], position[1]) - p[2];
  return true;
}

struct GroupCounts { unsigned lattices[SHAPES] = {}, loose[SHAPES] = {}, solid[SHAPES] = {}; };

// Every edge of every quad is in a leaf of the group (its own, if they are loose) within
// half a thickness of the surface; on the border it is not above it, and within the
// border's width. So is every edge that is off by no more than the rounding.
void expectEdgesBounded(uint32_t seed, unsigned groups, double rounding, GroupCounts& counts)
{
  Random random(seed);
  for (int shape = 0; shape < SHAPES; shape++)
    for (unsigned repeat = 0; repeat < groups; repeat++) {
      SCOPED_TRACE(testing::Message() << "shape " << shape << ", group " << repeat);
      const NodeBox parent = randomBox(random);
      QuadGroup group;
      makeGroup(random, Shape(shape), parent, group, rounding);
      const EncodedGroup encoded = encodeGroup(parent, group);
      const float width = borderWidthOf(LeafEncoder::encodeBorderWidth(encoded.borderWidth));
      const bool isLattice = !isLoose(encoded.heights);
      (isLattice ? counts.lattices : counts.loose)[shape]++;
      LeafPatch leaves[4];
      for (int c = 0; c < 4; c++) {
        leaves[c] = decodeLeaf(encoded.word, encoded.heights, c, parent);
        ASSERT_FALSE(leaves[c].empty);
        counts.solid[shape] += leaves[c].solid;
      }
      for (int quad = 0; quad < 4; quad++)
        for (int edge = 0; edge < 4; edge++)
          for (int step = 0; step <= 8; step++) {
            const int axis = edge/2, upper = edge % 2; // the side of the quad
            const double* a = group.vertexOf(quad, axis == 0 ? upper : 2*upper);
            const double* b = group.vertexOf(quad, axis == 0 ? upper + 2 : 2*upper + 1);
            double p[3];
            for (int k = 0; k < 3; k++) p[k] = a[k] + step*(b[k] - a[k])/8 + (rounding ? (random.chance(0.5) ? 1 : -1)*group.rounding[k] : 0);
            const bool onBorder = childColumn(quad, axis) == upper && group.border[axis][upper];
            bool found = false;
            for (int c = 0; c < 4; c++) {
              if (!isLattice && c != quad) continue;
              double distance, position[2];
              if (!surfaceAbove(leaves[c], p, distance, position)) continue;
              found = true;
              if (leaves[c].solid) continue;
              ASSERT_LE(std::fabs(distance), 0.5*leaves[c].thickness + tolerance) << "quad " << quad << ", edge " << edge;
              if (!onBorder) continue;
              ASSERT_GE(distance, -tolerance) << "quad " << quad << ", edge " << edge;
              ASSERT_EQ(childColumn(c, axis), upper) << "the leaf that has the edge is not on the border";
              ASSERT_LE(upper ? 1 - position[axis] : position[axis], width) << "quad " << quad << ", edge " << edge;
            }
            ASSERT_TRUE(found) << "quad " << quad << ", edge " << edge << " is in no leaf";
          }
    }
}

TEST(LeafCodec, LeavesBoundTheEdgesOfTheirQuads)
{
  GroupCounts counts;
  expectEdgesBounded(11, 4000, 0, counts);
  // each answer is given where it is the right one
  for (Shape shape : {REGULAR, WAVY, JITTERED, STEEP, ROUGH}) EXPECT_GT(counts.lattices[shape], 3000u) << "shape " << shape;
  for (Shape shape : {FOLDED, COLLAPSED, VERTICAL, ANYWHERE}) EXPECT_GT(counts.loose[shape], 3000u) << "shape " << shape;
  EXPECT_GT(counts.solid[ANYWHERE], 0u);
  EXPECT_LT(counts.solid[COLLAPSED], 4*counts.loose[COLLAPSED]);
}

// Far from the origin neighbours round a common vertex apart by a good part of a bin.
TEST(LeafCodec, LeavesBoundEdgesWhereNeighboursHaveThem)
{
  GroupCounts counts;
  expectEdgesBounded(16, 2000, 5e-4, counts);
  for (Shape shape : {REGULAR, WAVY, JITTERED, STEEP, ROUGH}) EXPECT_GT(counts.lattices[shape], 1000u) << "shape " << shape;
}

// The encoder moves heights until no vertex is off by more than 1/16 of a bin, then rounds
// each by half a bin at most, and a patch weighs its four by weights that sum up to 1.
TEST(LeafCodec, LatticesPassThroughTheirVerticesWithinHalfABin)
{
  Random random(12);
  for (Shape shape : {REGULAR, WAVY, JITTERED, STEEP, ROUGH}) {
    unsigned lattices = 0;
    for (int repeat = 0; repeat < 2000; repeat++) {
      const NodeBox parent = randomBox(random);
      QuadGroup group;
      makeGroup(random, shape, parent, group);
      for (auto& axis : group.border) axis[0] = axis[1] = false;
      const EncodedGroup encoded = encodeGroup(parent, group);
      if (isLoose(encoded.heights)) continue;
      lattices++;
      const double bin = latticeRange/latticeBins*parent.extent[2];
      bool found[9] = {};
      for (int vertex = 0; vertex < 9; vertex++)
        for (int leaf = 0; leaf < 4; leaf++) {
          double distance, position[2];
          if (!surfaceAbove(decodeLeaf(encoded.word, encoded.heights, leaf, parent), group.vertices[vertex], distance, position)) continue;
          found[vertex] = true;
          ASSERT_LE(std::fabs(distance), (0.5 + 1.0/16)*bin + tolerance) << "shape " << shape << ", group " << repeat << ", vertex " << vertex;
        }
      ASSERT_EQ(std::count(found, found + 9, true), 9) << "shape " << shape << ", group " << repeat;
    }
    EXPECT_GT(lattices, 1500u) << "shape " << shape;
  }
}

TEST(LeafCodec, EveryHeightIsReadBack)
{
  Random random(14);
  for (int vertex = 0; vertex < 9; vertex++)
    for (int height = 0; height < latticeBins; height++) {
      int heights[9];
      for (int& h : heights) h = int(random.below(latticeBins));
      heights[vertex] = height;
      const Heights bits = packLattice(heights);
      ASSERT_FALSE(isLoose(bits));
      for (int v = 0; v < 9; v++) ASSERT_EQ(latticeHeight(bits, v), heights[v]);
    }
}

// Siblings of a lattice share the planes between them and the heights along them.
TEST(LeafCodec, LatticesHaveNoStepsBetweenSiblings)
{
  Random random(15);
  for (int repeat = 0; repeat < 2000; repeat++) {
    int heights[9];
    for (int& h : heights) h = int(random.below(latticeBins));
    const Heights bits = packLattice(heights);
    const uint32_t word = uint32_t(random.below(1u << 30));
    const NodeBox parent = randomBox(random);
    LeafPatch leaf[4];
    for (int c = 0; c < 4; c++) leaf[c] = decodeLeaf(word, bits, c, parent);
    for (int i = 0; i < 2; i++) {
      ASSERT_FLOAT_EQ(upperOf(leaf[2*i].box, 0), leaf[2*i+1].box.lower[0]);
      ASSERT_FLOAT_EQ(upperOf(leaf[i].box, 1), leaf[2+i].box.lower[1]);
      for (int j = 0; j < 2; j++) {
        ASSERT_EQ(leaf[2*i].z[2*j+1], leaf[2*i+1].z[2*j]);
        ASSERT_EQ(leaf[i].z[2+j], leaf[2+i].z[j]);
      }
    }
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

      std::vector<Double3> scratch(BlockEncoder::scratchBytes(height)/sizeof(Double3) + 2), memory(blockLayout(uint32_t(Kind::LEAF), height).bytes/sizeof(Double3) + 2);
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
        const Heights heights = heightsOf(block, m/4);
        ASSERT_EQ(isLoose(heights) && looseLeaf(heights, int(m%4)) == emptyLeaf, expected) << "height " << height << ", quad " << m;
      }
      EXPECT_EQ(stats.invalidQuads, count);
    }
}

// World distance between the two bounds of a leaf, from points of both.
double worldThickness(const InverseFrame& inverse, const LeafPatch& leaf)
{
  const double slope[2] = {0.5*((leaf.z[1] + leaf.z[3]) - (leaf.z[0] + leaf.z[2]))/leaf.box.extent[0],
                           0.5*((leaf.z[2] + leaf.z[3]) - (leaf.z[0] + leaf.z[1]))/leaf.box.extent[1]};
  double c[3];
  for (int k = 0; k < 3; k++) c[k] = leaf.box.lower[k] + 0.5*leaf.box.extent[k];
  const double step = 1e-6;
  const Double3 o = inverse({c[0], c[1], c[2]});
  const Double3 x = inverse({c[0] + step, c[1], c[2] + step*slope[0]}) - o, y = inverse({c[0], c[1] + step, c[2] + step*slope[1]}) - o;
  const Double3 z = inverse({c[0], c[1], c[2] + step}) - o, n = cross(x, y);
  return std::fabs(dot(n, z))/length(n)*leaf.thickness/step;
}

double largestThickness(const Block* block, const InverseFrame& inverse, uint32_t level, uint32_t m, const NodeBox& box)
{
  double largest = 0;
  for (uint32_t c = 0; c < 4; c++) {
    const bool last = level + 1 == block->layout().nodeLevels;
    largest = std::max(largest, last ? worldThickness(inverse, leafOfGroup(block, m, c, box))
                                     : largestThickness(block, inverse, level + 1, 4*m + c, childBox(block, level, m, c, box)));
  }
  return largest;
}

// In projective frames, where a unit of the frame is not everywhere the same in the world, and
// on slopes, where a leaf is thinner across than it is high.
TEST(LeafCodec, ThicknessIsThatOfTheWorld)
{
  constexpr uint32_t height = 4, n = 1 << height, width = n + 1;
  const float corners[4][3] = {{0, 0, 0}, {4, 0, 0}, {1.4f, 3, 0}, {2.6f, 3, 0}};
  unsigned compared = 0;
  for (float slope : {0.0f, 0.3f, 3.0f}) {
    std::vector<float> vertices;
    for (uint32_t y = 0; y < width; y++)
      for (uint32_t x = 0; x < width; x++) {
        const float u = float(x)/n, v = float(y)/n;
        for (int k = 0; k < 2; k++)
          vertices.push_back((1-v)*((1-u)*corners[0][k] + u*corners[1][k]) + v*((1-u)*corners[2][k] + u*corners[3][k]));
        vertices.push_back(slope*vertices[vertices.size() - 2] + 0.02f*std::sin(9*u + 5*v));
      }
    std::vector<Double3> scratch(BlockEncoder::scratchBytes(height)/sizeof(Double3) + 2), memory(blockLayout(kindLeaf, height).bytes/sizeof(Double3) + 2);
    auto align = [](void* p) { return (void*)((uintptr_t(p) + 15) & ~uintptr_t(15)); };
    BlockEncoder encoder(Kind::LEAF, height, (const float(*)[3])vertices.data(), align(scratch.data()));
    ASSERT_TRUE(encoder.fit(corners));
    Block* block = (Block*)align(memory.data());
    BlockStatistics stats;
    encoder.encode(block, 0, 0, stats);
    ASSERT_FALSE(stats.affine);
    ASSERT_EQ(stats.solidLeaves, 0u);
    const double expected = largestThickness(block, InverseFrame(frameMap(block)), 0, 0, rootBox());
    EXPECT_NEAR(stats.maxThickness, expected, 1e-3*expected) << "slope " << slope;
    compared++;
  }
  EXPECT_EQ(compared, 3u);
}

} // namespace
} // namespace cbvh::test
