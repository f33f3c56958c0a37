// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Leaves of cLEAF: stored leaves bound the edges of the quads, or the encoder reports that it cannot bound them. */

#include "kernels/cbvh/paper/leaf/crossing.h"
#include "kernels/cbvh/paper/tree.h"
#include "support/encoded_block.h"
#include "support/random.h"

#include <algorithm>
#include <array>
#include <limits>
#include <ostream>
#include <vector>

namespace programs::test { namespace {

using namespace embree::cbvh;

constexpr double floatRounding = 0x1p-20; // of float arithmetic on numbers up to 4
constexpr double tolerance = containmentSlack + floatRounding;

// Up to ROUGH, height fields over the parent's box.
enum Shape { REGULAR, WAVY, JITTERED, STEEP, ROUGH, FOLDED, ANYWHERE, COLLAPSED, VERTICAL, SHAPES };

// rounding: largest distance of a neighboring face's copies of vertices, in parent extents.
void makeGroup(Random& random, Shape shape, const NodeBox& parent, QuadGroup& group, double rounding = 0) {
  const double slopeX = random.uniform(-1, 1), slopeY = random.uniform(-1, 1), bend = random.uniform(-1, 1);
  for (int v = 0; v < 9; v++) {
    double x = 0.05 + 0.45 * (v % 3), y = 0.05 + 0.45 * (v / 3),
           z = 0.5 + 0.2 * slopeX * (x - 0.5) + 0.2 * slopeY * (y - 0.5) + 0.3 * bend * (x - 0.5) * (y - 0.5);
    switch (shape) {
    case WAVY: z += 0.1 * std::sin(7 * x + 3 * y + 6 * bend); break;
    case JITTERED:
      x += random.uniform(-0.05, 0.05);
      y += random.uniform(-0.05, 0.05);
      z += 0.05 * random.uniform();
      break;
    case STEEP: z = 0.1 + 0.4 * (x + y); break;
    case ROUGH: z = random.uniform(0.2, 0.8); break;
    case FOLDED:
      if (v % 3 == 1) x = 0.97;
      break;
    case COLLAPSED: x = y = 0.5; break;
    case VERTICAL:
      z = x;
      x = 0.5;
      break;
    case ANYWHERE:
      x = random.uniform();
      y = random.uniform();
      z = random.uniform();
      break;
    default: break;
    }
    const double p[3] = {x, y, z};
    for (int k = 0; k < 3; k++)
      group.vertices[v][k] = parent.lower[k] + parent.extent[k] * std::min(0.999, std::max(0.001, p[k]));
  }
  for (int k = 0; k < 3; k++) group.rounding[k] = rounding * parent.extent[k];
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

NodeBox randomBox(Random& random) {
  NodeBox box;
  for (int axis = 0; axis < 3; axis++) {
    box.extent[axis] = float(random.magnitude(1.0 / 64, 1.0));
    box.lower[axis] = float(random.uniform(0, 1 - box.extent[axis]));
  }
  return box;
}

// distance: along z, positive if the surface is above p. Returns false if p is outside of the leaf's box.
bool surfaceAbove(const LeafPatch& leaf, const double p[3], double& distance, double position[2]) {
  for (int k = 0; k < 3; k++)
    if (p[k] < leaf.box.lower[k] - tolerance || p[k] > upperOf(leaf.box, k) + tolerance) return false;
  for (int k = 0; k < 2; k++)
    position[k] = std::min(1.0, std::max(0.0, (p[k] - leaf.box.lower[k]) / leaf.box.extent[k]));
  distance = patchZ(leaf, position[0], position[1]) - p[2];
  return true;
}

// The four leaves of a group.
struct GroupLeaves {
  LeafPatch leaf[4];
  bool isLattice;

  GroupLeaves(uint32_t word, Heights heights, const NodeBox& parent) : isLattice(!hasSeparateLeaves(heights)) {
    for (int c = 0; c < 4; c++) leaf[c] = decodeLeaf(word, heights, c, parent);
  }
};

// Edge of a quad of a group: its lower or upper side along an axis.
struct EdgeOfGroup {
  int quad, axis, upper;
  bool onBorder;
};
std::ostream& operator<<(std::ostream& out, const EdgeOfGroup& e) {
  return out << "quad " << e.quad << ", " << (e.upper ? "upper" : "lower") << " side along axis " << e.axis;
}

// A point of an edge must be in a leaf of the group (if leaves are separate, the quad's own) within half a thickness of
// the surface. On the border of a block it must be below the surface, and within the border's width.
void expectBounded(const GroupLeaves& leaves, const EdgeOfGroup& edge, const double p[3], float borderWidth) {
  bool found = false;
  for (int c = 0; c < 4; c++) {
    if (!leaves.isLattice && c != edge.quad) continue;
    double distance, position[2];
    if (!surfaceAbove(leaves.leaf[c], p, distance, position)) continue;
    found = true;
    if (leaves.leaf[c].solid) continue;
    ASSERT_LE(std::fabs(distance), 0.5 * leaves.leaf[c].thickness + tolerance) << edge;
    if (!edge.onBorder) continue;
    ASSERT_GE(distance, -tolerance) << edge << " is above the surface";
    ASSERT_EQ(childCoordinate(c, edge.axis), edge.upper) << edge << " is in a leaf that is not on the border";
    ASSERT_LE(edge.upper ? 1 - position[edge.axis] : position[edge.axis], borderWidth) << edge;
  }
  ASSERT_TRUE(found) << edge << " is in no leaf";
}

struct GroupCounts {
  unsigned lattices[SHAPES] = {}, separate[SHAPES] = {}, solid[SHAPES] = {};
};

// Including edges that deviate by the rounding.
void expectEdgesBounded(uint32_t seed, unsigned groups, double rounding, GroupCounts& counts) {
  Random random(seed);
  for (int shape = 0; shape < SHAPES; shape++)
    for (unsigned repeat = 0; repeat < groups; repeat++) {
      SCOPED_TRACE(testing::Message() << "shape " << shape << ", group " << repeat);
      const NodeBox parent = randomBox(random);
      QuadGroup group;
      makeGroup(random, Shape(shape), parent, group, rounding);
      const EncodedGroup encoded = encodeGroup(parent, group);
      const float width = borderWidthOf(LeafEncoder::encodeBorderWidth(encoded.borderWidth));
      const GroupLeaves leaves(encoded.word, encoded.heights, parent);
      (leaves.isLattice ? counts.lattices : counts.separate)[shape]++;
      for (const LeafPatch& leaf : leaves.leaf) {
        ASSERT_FALSE(leaf.empty);
        counts.solid[shape] += leaf.solid;
      }
      for (int quad = 0; quad < 4; quad++)
        for (int side = 0; side < 4; side++) {
          const int axis = side / 2, upper = side % 2;
          const EdgeOfGroup edge = {quad, axis, upper,
                                    childCoordinate(quad, axis) == upper && group.border[axis][upper]};
          const double* a = group.vertexOf(quad, axis == 0 ? upper : 2 * upper);
          const double* b = group.vertexOf(quad, axis == 0 ? upper + 2 : 2 * upper + 1);
          for (int step = 0; step <= 8; step++) {
            double p[3];
            for (int k = 0; k < 3; k++)
              p[k] =
                  a[k] + step * (b[k] - a[k]) / 8 + (rounding ? (random.chance(0.5) ? 1 : -1) * group.rounding[k] : 0);
            expectBounded(leaves, edge, p, width);
          }
        }
      if (testing::Test::HasFatalFailure()) return;
    }
}

TEST(LeafCodec, LeavesBoundEdgesOfTheirQuads) {
  GroupCounts counts;
  expectEdgesBounded(11, 4000, 0, counts);
  // the group type must be used for the shapes that it is intended for
  for (Shape shape : {REGULAR, WAVY, JITTERED, STEEP, ROUGH})
    EXPECT_GT(counts.lattices[shape], 3000u) << "shape " << shape;
  for (Shape shape : {FOLDED, COLLAPSED, VERTICAL, ANYWHERE})
    EXPECT_GT(counts.separate[shape], 3000u) << "shape " << shape;
  EXPECT_GT(counts.solid[ANYWHERE], 0u);
  EXPECT_LT(counts.solid[COLLAPSED], 4 * counts.separate[COLLAPSED]);
}

// Far from the origin, neighbors round copies of a vertex to positions that differ by a large part of a bin.
TEST(LeafCodec, LeavesBoundNeighborsCopiesOfEdges) {
  GroupCounts counts;
  expectEdgesBounded(16, 2000, 5e-4, counts);
  for (Shape shape : {REGULAR, WAVY, JITTERED, STEEP, ROUGH})
    EXPECT_GT(counts.lattices[shape], 1000u) << "shape " << shape;
}

// --- whole blocks --------------------------------------------------------------------------

// Displaced vertices of a quad, row by row.
std::vector<float> displacedQuad(Random& random, uint32_t height, const float corners[4][3], Shape shape) {
  const uint32_t n = 1u << height;
  const double phase = 6 * random.uniform();
  std::vector<float> vertices;
  for (uint32_t y = 0; y <= n; y++)
    for (uint32_t x = 0; x <= n; x++) {
      const double u = double(x) / n, v = double(y) / n;
      double p[3];
      for (int k = 0; k < 3; k++)
        p[k] =
            (1 - v) * ((1 - u) * corners[0][k] + u * corners[1][k]) + v * ((1 - u) * corners[2][k] + u * corners[3][k]);
      if (shape == WAVY) p[2] += 0.1 * std::sin(7 * u + 3 * v + phase);
      if (shape == ROUGH) p[2] += 0.5 / n * random.uniform(-1, 1);
      if (shape == ANYWHERE)
        for (double& c : p) c += 0.7 / n * random.uniform(-1, 1);
      vertices.insert(vertices.end(), {float(p[0]), float(p[1]), float(p[2])});
    }
  return vertices;
}

NodeBox decodedBox(const Block* block, uint32_t level, uint32_t m) {
  NodeBox box = rootBox();
  for (uint32_t l = 0; l < level; l++)
    box = childBox(block, l, m >> 2 * (level - l), (m >> 2 * (level - l - 1)) & 3, box);
  return box;
}

// One of the four sides of a block, vertex by vertex, in its frame.
struct Side {
  int axis, upper;
  std::vector<Double3> vertices;

  Side(const Frame& frame, uint32_t quads, const std::vector<float>& surface, int axis, int upper)
    : axis(axis),
      upper(upper) {
    for (uint32_t i = 0; i <= quads; i++) {
      const uint32_t across = upper ? quads : 0, x = axis == 0 ? across : i, y = axis == 0 ? i : across;
      double p[3];
      frame.transform(&surface[3 * (y * (quads + 1) + x)], p);
      vertices.push_back({p[0], p[1], p[2]});
    }
  }

  // t: in vertices.
  Double3 at(double t) const {
    const size_t i = std::min(size_t(t), vertices.size() - 2);
    return vertices[i] + (t - double(i)) * (vertices[i + 1] - vertices[i]);
  }

  // Morton index of the i-th of the `cells` cells along it.
  uint32_t cell(uint32_t i, uint32_t cells) const {
    return axis == 0 ? morton(upper ? cells - 1 : 0, i) : morton(i, upper ? cells - 1 : 0);
  }
};

// By at most half a thickness and within the width of lips. Otherwise rays could pass between blocks.
TEST(LeafCodec, BlocksAreAboveTheirEdgesOnAllSides) {
  Random random(18);
  const float square[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}},
              trapezoid[4][3] = {{0, 0, 0}, {1, 0, 0}, {0.3f, 1, 0}, {0.7f, 1, 0}};
  unsigned lattices[4] = {}, separate[4] = {};
  for (uint32_t height = 0; height <= 4; height++)
    for (const auto* corners : {square, trapezoid})
      for (Shape shape : {WAVY, ROUGH, ANYWHERE})
        for (int repeat = 0; repeat < 20; repeat++) {
          SCOPED_TRACE(testing::Message() << "height " << height << ", " << (corners == square ? "square" : "trapezoid")
                                          << ", shape " << shape << ", block " << repeat);
          const std::vector<float> vertices = displacedQuad(random, height, corners, shape);
          const EncodedBlock encoded(Kind::CLEAF, height, vertices, corners);
          ASSERT_TRUE(encoded);
          const Block* block = encoded.get();
          const uint32_t quads = 1u << height, levels = block->layout().nodeLevels,
                         cells = block->layout().leavesPerSide;
          for (int s = 0; s < 4; s++) {
            const Side side(encoded.frame(), quads, vertices, s / 2, s % 2);
            for (uint32_t i = 0; i < cells; i++) {
              const uint32_t m = side.cell(i, cells);
              const GroupLeaves leaves(block->nodes()[nodesOfLevels(levels - 1) + m / 4], heightsOf(block, m / 4),
                                       decodedBox(block, levels - 1, m / 4));
              (leaves.isLattice ? lattices : separate)[s]++;
              for (int step = 0; step <= 8; step++) {
                const Double3 p = side.at((i + step / 8.0) * quads / cells);
                const double local[3] = {p.x, p.y, p.z};
                expectBounded(leaves, {int(m % 4), side.axis, side.upper, true}, local, borderWidthOf(block->info));
              }
            }
          }
          if (HasFatalFailure()) return;
        }
  for (int s = 0; s < 4; s++) {
    EXPECT_GT(lattices[s], 2000u);
    EXPECT_GT(separate[s], 500u);
  }
}

// --- lattices ------------------------------------------------------------------------------

// The contract of QuadGroup::slack(), for the decoded surface: edges keep that distance from both ends of the
// thickness. Edges on the border also keep it from the surface.
void expectSlackOfSurface(const GroupLeaves& leaves, const QuadGroup& group) {
  double slope[2] = {};
  for (const LeafPatch& leaf : leaves.leaf)
    for (int i = 0; i < 2; i++) {
      slope[0] = std::max(slope[0], std::fabs(double(leaf.z[2 * i + 1]) - leaf.z[2 * i]) / leaf.box.extent[0]);
      slope[1] = std::max(slope[1], std::fabs(double(leaf.z[2 + i]) - leaf.z[i]) / leaf.box.extent[1]);
    }
  const double slack = group.slack(slope) - floatRounding;
  for (int quad = 0; quad < 4; quad++)
    for (int side = 0; side < 4; side++) {
      const int axis = side / 2, upper = side % 2;
      const EdgeOfGroup edge = {quad, axis, upper, childCoordinate(quad, axis) == upper && group.border[axis][upper]};
      const double* a = group.vertexOf(quad, axis == 0 ? upper : 2 * upper);
      const double* b = group.vertexOf(quad, axis == 0 ? upper + 2 : 2 * upper + 1);
      for (int step = 0; step <= 8; step++) {
        double p[3];
        for (int k = 0; k < 3; k++) p[k] = a[k] + step * (b[k] - a[k]) / 8;
        bool found = false;
        for (const LeafPatch& leaf : leaves.leaf) {
          double distance, position[2];
          if (!surfaceAbove(leaf, p, distance, position)) continue;
          found = true;
          ASSERT_LE(std::fabs(distance) + slack, 0.5 * leaf.thickness) << edge;
          if (edge.onBorder) { ASSERT_GE(distance, slack) << edge; }
        }
        ASSERT_TRUE(found) << edge << " is in no leaf";
      }
    }
}

// Raising the border makes a surface steeper. Steeper surfaces need more slack if vertices are imprecise.
TEST(LeafCodec, RaisedLatticesKeepTheSlackOfTheirSlopes) {
  Random random(53);
  unsigned lattices = 0;
  for (int shape = 0; shape < SHAPES; shape++)
    for (int repeat = 0; repeat < 2000; repeat++) {
      const NodeBox parent = randomBox(random);
      QuadGroup group;
      makeGroup(random, Shape(shape), parent, group, random.magnitude(1e-4, 0.02));
      EncodedGroup encoded;
      if (!encodeLattice(parent, group, encoded)) continue;
      lattices++;
      SCOPED_TRACE(testing::Message() << "shape " << shape << ", group " << repeat);
      expectSlackOfSurface(GroupLeaves(encoded.word, encoded.heights, parent), group);
      if (HasFatalFailure()) return;
    }
  EXPECT_GT(lattices, 3000u);
}

// Far from the origin, vertices of small blocks are imprecise.
TEST(LeafCodec, SmallDistantBlocksKeepTheSlackOfTheirSlopes) {
  Random random(54);
  const float size = 0.05f, corners[4][3] = {{1000, 1000, 1000},
                                             {1000 + size, 1000, 1000},
                                             {1000, 1000 + size, 1000},
                                             {1000 + size, 1000 + size, 1000}};
  unsigned lattices = 0;
  for (uint32_t height = 1; height <= 4; height++)
    for (int repeat = 0; repeat < 100; repeat++) {
      const uint32_t side = (1u << height) + 1;
      const double phase = 6 * random.uniform();
      std::vector<float> vertices;
      for (uint32_t v = 0; v < side * side; v++) {
        const double x = double(v % side) / (side - 1), y = double(v / side) / (side - 1),
                     p[3] = {x, y, 0.3 * std::sin(7 * x + 3 * y + phase)};
        for (double coordinate : p) vertices.push_back(float(1000 + size * coordinate));
      }
      const EncodedBlock encoded(Kind::CLEAF, height, vertices, corners);
      ASSERT_TRUE(encoded);
      std::vector<Double4> scratch(BlockGeometry::scratchBytes(height) / sizeof(Double4) + 1);
      BlockGeometry geometry(Kind::CLEAF, height, (const float(*)[3])vertices.data(), scratch.data());
      ASSERT_TRUE(geometry.fit(corners));
      geometry.computeBounds();
      EXPECT_GT(geometry.rounding[0], 0.004);
      for (uint32_t m = 0; m < 1u << 2 * (height - 1); m++) {
        const GroupLeaves leaves(encoded.get()->nodes()[nodesOfLevels(height - 1) + m], heightsOf(encoded.get(), m),
                                 decodedBox(encoded.get(), height - 1, m));
        if (!leaves.isLattice) continue;
        lattices++;
        QuadGroup group;
        const uint32_t x = 2 * mortonX(m), y = 2 * mortonY(m);
        for (uint32_t v = 0; v < 9; v++)
          std::copy_n(geometry.local[(y + v / 3) * side + x + v % 3], 3, group.vertices[v]);
        std::copy_n(geometry.rounding, 3, group.rounding);
        group.border[0][0] = x == 0;
        group.border[0][1] = x + 3 == side;
        group.border[1][0] = y == 0;
        group.border[1][1] = y + 3 == side;
        SCOPED_TRACE(testing::Message() << "height " << height << ", block " << repeat << ", group " << m);
        expectSlackOfSurface(leaves, group);
        if (HasFatalFailure()) return;
      }
    }
  EXPECT_GT(lattices, 5000u);
}

// The encoder adjusts heights until each vertex is within 1/16 of a bin, then rounds each height by at most half a
// bin. A patch is a convex combination of four heights.
TEST(LeafCodec, LatticesMatchVerticesWithinHalfABin) {
  Random random(12);
  for (Shape shape : {REGULAR, WAVY, JITTERED, STEEP, ROUGH}) {
    unsigned lattices = 0;
    for (int repeat = 0; repeat < 2000; repeat++) {
      const NodeBox parent = randomBox(random);
      QuadGroup group;
      makeGroup(random, shape, parent, group);
      for (auto& axis : group.border) axis[0] = axis[1] = false;
      const EncodedGroup encoded = encodeGroup(parent, group);
      if (hasSeparateLeaves(encoded.heights)) continue;
      lattices++;
      const double bin = latticeRange / latticeBins * parent.extent[2];
      bool found[9] = {};
      for (int vertex = 0; vertex < 9; vertex++)
        for (int leaf = 0; leaf < 4; leaf++) {
          double distance, position[2];
          if (!surfaceAbove(decodeLeaf(encoded.word, encoded.heights, leaf, parent), group.vertices[vertex], distance,
                            position))
            continue;
          found[vertex] = true;
          ASSERT_LE(std::fabs(distance), (0.5 + 1.0 / 16) * bin + tolerance)
              << "shape " << shape << ", group " << repeat << ", vertex " << vertex;
        }
      ASSERT_EQ(std::count(found, found + 9, true), 9) << "shape " << shape << ", group " << repeat;
    }
    EXPECT_GT(lattices, 1500u) << "shape " << shape;
  }
}

TEST(LeafCodec, EveryHeightRoundTrips) {
  Random random(14);
  for (int vertex = 0; vertex < 9; vertex++)
    for (int height = 0; height < latticeBins; height++) {
      int heights[9];
      for (int& h : heights) h = int(random.below(latticeBins));
      heights[vertex] = height;
      const Heights bits = packLattice(heights);
      ASSERT_FALSE(hasSeparateLeaves(bits));
      for (int v = 0; v < 9; v++) ASSERT_EQ(latticeHeight(bits, v), heights[v]);
    }
}

TEST(LeafCodec, LatticesAreContinuousBetweenSiblings) {
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
      ASSERT_FLOAT_EQ(upperOf(leaf[2 * i].box, 0), leaf[2 * i + 1].box.lower[0]);
      ASSERT_FLOAT_EQ(upperOf(leaf[i].box, 1), leaf[2 + i].box.lower[1]);
      for (int j = 0; j < 2; j++) {
        ASSERT_EQ(leaf[2 * i].z[2 * j + 1], leaf[2 * i + 1].z[2 * j]);
        ASSERT_EQ(leaf[i].z[2 + j], leaf[2 + i].z[j]);
      }
    }
  }
}

TEST(LeafCodec, OnlyQuadsWithNonFiniteVerticesAreEmpty) {
  Random random(13);
  const float bad[3] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                        -std::numeric_limits<float>::infinity()};
  for (uint32_t height = 0; height <= 4; height++)
    for (int repeat = 0; repeat < 20; repeat++) {
      const uint32_t n = 1u << height, width = n + 1;
      std::vector<float> vertices(3 * width * width);
      for (uint32_t y = 0; y < width; y++)
        for (uint32_t x = 0; x < width; x++) {
          float* p = &vertices[3 * (y * width + x)];
          p[0] = float(x);
          p[1] = float(y);
          p[2] = float(0.3 * random.uniform());
        }
      float corners[4][3];
      for (int c = 0; c < 4; c++) std::copy_n(&vertices[3 * ((c >> 1) * n * width + (c & 1) * n)], 3, corners[c]);
      for (int i = 0; i < repeat % 5; i++) vertices[random.below(3 * width * width)] = bad[random.below(3)];

      const EncodedBlock encoded(Kind::CLEAF, height, vertices, corners);
      auto isBad = [&](uint32_t x, uint32_t y) {
        for (uint32_t c = 0; c < 4; c++)
          for (int k = 0; k < 3; k++)
            if (!std::isfinite(vertices[3 * ((y + (c >> 1)) * width + x + (c & 1)) + k])) return true;
        return false;
      };
      if (!encoded) continue; // all vertices are invalid
      uint32_t count = 0;
      for (uint32_t m = 0; m < n * n; m++) {
        const bool expected = isBad(mortonX(m), mortonY(m));
        count += expected;
        const Heights heights = heightsOf(encoded.get(), m / 4);
        ASSERT_EQ(hasSeparateLeaves(heights) && separateLeaf(heights, int(m % 4)) == emptyLeaf, expected)
            << "height " << height << ", quad " << m;
      }
      EXPECT_EQ(encoded.statistics.invalidQuads, count);
    }
}

// Distance of the two bounds of a leaf in world space, by finite differences at its center.
double worldThickness(const InverseFrame& inverse, const LeafPatch& leaf) {
  const double slope[2] = {0.5 * ((leaf.z[1] + leaf.z[3]) - (leaf.z[0] + leaf.z[2])) / leaf.box.extent[0],
                           0.5 * ((leaf.z[2] + leaf.z[3]) - (leaf.z[0] + leaf.z[1])) / leaf.box.extent[1]};
  double c[3];
  for (int k = 0; k < 3; k++) c[k] = leaf.box.lower[k] + 0.5 * leaf.box.extent[k];
  const double step = 1e-6;
  const Double3 o = inverse({c[0], c[1], c[2]});
  const Double3 x = inverse({c[0] + step, c[1], c[2] + step * slope[0]}) - o,
                y = inverse({c[0], c[1] + step, c[2] + step * slope[1]}) - o;
  const Double3 z = inverse({c[0], c[1], c[2] + step}) - o, n = cross(x, y);
  return std::fabs(dot(n, z)) / length(n) * leaf.thickness / step;
}

double largestThickness(const Block* block, const InverseFrame& inverse, uint32_t level, uint32_t m,
                        const NodeBox& box) {
  double largest = 0;
  for (uint32_t c = 0; c < 4; c++) {
    const bool last = level + 1 == block->layout().nodeLevels;
    largest = std::max(
        largest, last ? worldThickness(inverse, leafOfGroup(block, m, c, box))
                      : largestThickness(block, inverse, level + 1, 4 * m + c, childBox(block, level, m, c, box)));
  }
  return largest;
}

// In projective frames a unit of the frame varies in world space. On slopes a leaf is thinner than its height.
TEST(LeafCodec, ThicknessIsInWorldSpace) {
  constexpr uint32_t height = 4, n = 1 << height, width = n + 1;
  const float corners[4][3] = {{0, 0, 0}, {4, 0, 0}, {1.4f, 3, 0}, {2.6f, 3, 0}};
  unsigned compared = 0;
  for (float slope : {0.0f, 0.3f, 3.0f}) {
    std::vector<float> vertices;
    for (uint32_t y = 0; y < width; y++)
      for (uint32_t x = 0; x < width; x++) {
        const float u = float(x) / n, v = float(y) / n;
        for (int k = 0; k < 2; k++)
          vertices.push_back((1 - v) * ((1 - u) * corners[0][k] + u * corners[1][k]) +
                             v * ((1 - u) * corners[2][k] + u * corners[3][k]));
        vertices.push_back(slope * vertices[vertices.size() - 2] + 0.02f * std::sin(9 * u + 5 * v));
      }
    const EncodedBlock encoded(Kind::CLEAF, height, vertices, corners);
    ASSERT_TRUE(encoded);
    const Block* block = encoded.get();
    ASSERT_FALSE(encoded.statistics.affine);
    ASSERT_EQ(encoded.statistics.solidLeaves, 0u);
    const double expected = largestThickness(block, InverseFrame(frameMap(block)), 0, 0, rootBox());
    EXPECT_NEAR(encoded.statistics.maxThickness, expected, 1e-3 * expected) << "slope " << slope;
    compared++;
  }
  EXPECT_EQ(compared, 3u);
}

// Four random groups of one parent, one per lane.
TEST(LeafCodec, FourLatticesAtOnceMatchSingleOnes) {
  Random random(47);
  unsigned encoded = 0, refused = 0, undecided = 0;
  for (int shape = 0; shape < SHAPES; shape++)
    for (int repeat = 0; repeat < 3000; repeat++) {
      SCOPED_TRACE(testing::Message() << "shape " << shape << ", groups " << repeat);
      const NodeBox parent = randomBox(random);
      const double rounding = std::array<double, 3>{0, 0x1p-12, 0x1p-7}[repeat % 3];
      QuadGroup groups[4];
      NodeBoxes parents;
      GroupLanes lanes;
      for (auto& sides : lanes.border)
        for (uint32_t& bits : sides) bits = 0;
      for (int lane = 0; lane < 4; lane++) {
        makeGroup(random, Shape(shape), parent, groups[lane], rounding);
        for (int k = 0; k < 3; k++) {
          parents.lower[k][lane] = parent.lower[k];
          parents.extent[k][lane] = parent.extent[k];
          lanes.rounding[k] = groups[lane].rounding[k];
        }
        for (int axis = 0; axis < 2; axis++)
          for (int upper = 0; upper < 2; upper++)
            lanes.border[axis][upper] |= uint32_t(groups[lane].border[axis][upper]) << lane;
      }
      ExactBox boxes[4];
      for (int lane = 0; lane < 4; lane++)
        for (const ExactBox& box : groups[lane].boxes) boxes[lane].extend(box);
      for (int k = 0; k < 3; k++)
        for (int v = 0; v < 9; v++)
          lanes.vertices[v][k] = Double4(groups[0].vertices[v][k], groups[1].vertices[v][k], groups[2].vertices[v][k],
                                         groups[3].vertices[v][k]);
      for (int k = 0; k < 2; k++) {
        lanes.lower[k] = Double4(boxes[0].lower[k], boxes[1].lower[k], boxes[2].lower[k], boxes[3].lower[k]);
        lanes.upper[k] = Double4(boxes[0].upper[k], boxes[1].upper[k], boxes[2].upper[k], boxes[3].upper[k]);
      }

      LatticeLanes lattices(parents, lanes);
      lattices.encode();
      uint32_t words[4];
      Heights heights[4];
      lattices.store(words, heights);
      ASSERT_EQ(lattices.encoded & lattices.undecided, 0u);
      for (int lane = 0; lane < 4; lane++) {
        if (lattices.undecided >> lane & 1) {
          undecided++;
          continue;
        }
        EncodedGroup expected;
        const bool hasLattice = encodeLattice(parent, groups[lane], expected);
        ASSERT_EQ(lattices.encoded >> lane & 1, uint32_t(hasLattice)) << "lane " << lane;
        (hasLattice ? encoded : refused)++;
        if (!hasLattice) continue;
        ASSERT_EQ(words[lane], expected.word) << "lane " << lane;
        ASSERT_EQ(heights[lane].low, expected.heights.low) << "lane " << lane;
        ASSERT_EQ(heights[lane].high, expected.heights.high) << "lane " << lane;
      }
    }
  EXPECT_GT(encoded, 10000u);
  EXPECT_GT(refused, 10000u);
  EXPECT_GT(undecided, 0u);
}

}} // namespace programs::test
