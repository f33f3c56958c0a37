// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares the traversal's decoders of nodes and of cLEAF groups with the scalar decoders of paper/node.h and
 * paper/leaf/format.h, child by child: random words, random parents. Compiled once for every ISA, outside of the
 * library.
 *
 * If all planes of a parent are multiples of 2^-12, no operation rounds: planes of nodes are multiples of 1/256 of
 * their parent's extent, planes of lattices of 1/1024, heights odd multiples of 3/512 in a lattice, and in separate
 * leaves of 1/32 of a child's extent, a multiple of 1/32 of the parent's. The finest are multiples of 2^-22 below 2,
 * which float represents. For such parents both results must be bit-identical, fused or not; for others they may round
 * differently, by at most maxRounding. */

#include "kernels/cbvh/paper/node_decoder4.h"
#include "support/random.h"

#include <cstring>

// for isa_check.cpp
extern const char* const programIsa;
const char* const programIsa = TEST_ISA;

namespace programs::test { namespace {

using namespace embree::cbvh;

// --- the kernels' decoders -----------------------------------------------------------

// Results for four children.
struct Lanes {
  float lower[3][4], upper[3][4];
  float z[4][4]; // at corners column + 2 row of the boxes, then children
  float thickness[4];
  size_t solid, empty;
};

// The only place that names the decoder classes. heights: of a group, or nullptr for a node, which has only boxes.
// first: position of the results among sixteen; the others remain unchanged.
Lanes decodeLanes(uint32_t word, const uint64_t* heights, const NodeBox& parent, uint32_t first) {
  using namespace embree;
  using namespace embree::isa::cbvh;
  NodePlanes<16> boxes;
  LeafSurfaces surfaces;
  std::memset(&boxes, 0x7F, sizeof(boxes));
  std::memset(&surfaces, 0x7F, sizeof(surfaces));
  const uint32_t untouched = surfaces.solid;
  if (heights) GroupDecoder4(boxes, surfaces, first).decode(word, *heights, parent);
  else decodeNode(word, parent, boxes, first);
  Lanes lanes = {};
  for (uint32_t i = 0; i < 16; i++) {
    float other;
    std::memset(&other, 0x7F, sizeof(other));
    const bool isOther = i - first >= 4;
    EXPECT_EQ(std::memcmp(&boxes.planes[0][0][i], &other, 4) == 0, isOther) << i;
    if (!isOther) {
      const uint32_t c = i - first;
      for (int axis = 0; axis < 3; axis++) {
        lanes.lower[axis][c] = boxes.planes[axis][0][i];
        lanes.upper[axis][c] = boxes.planes[axis][1][i];
      }
      if (!heights) continue;
      const float* h = surfaces.height[i];
      for (int corner = 0; corner < 4; corner++)
        lanes.z[corner][c] = h[0] + float(corner & 1) * h[1] + float(corner >> 1) * (h[2] + float(corner & 1) * h[3]);
      lanes.thickness[c] = 2 * surfaces.halfThickness[i];
    } else if (heights) {
      EXPECT_EQ((surfaces.solid >> i) & 1, (untouched >> i) & 1) << i;
      EXPECT_EQ((surfaces.empty >> i) & 1, (untouched >> i) & 1) << i;
    }
  }
  lanes.solid = heights ? (surfaces.solid >> first) & 15 : 0;
  lanes.empty = heights ? (surfaces.empty >> first) & 15 : 0;
  return lanes;
}

// --- comparison ----------------------------------------------------------------------

/* Roundings that may differ, each by at most half an ulp of a number below 2, 2^-24. A plane of a box: product, sum and
 * extent on both sides, 6. A height has these, and on both sides the origin of the bins, their size (times up to 128,
 * relative), their thickness, and in a separate leaf three of these at the fourth corner: less than 32. */
constexpr double maxRounding = 32 * 0x1p-24;

struct Comparison {
  double tolerance;

  // Random words may place a lattice above or below its parent's box, unlike an encoder. Such a box has no height, on
  // either side of the parent.
  void expectBox(const NodeBox& box, const Lanes& lanes, int lane) const {
    for (int axis = 0; axis < 3; axis++) {
      const double lower = lanes.lower[axis][lane], upper = lanes.upper[axis][lane];
      if (axis == 2 && box.extent[2] == 0) {
        ASSERT_NEAR(upper, lower, tolerance);
        continue;
      }
      ASSERT_NEAR(lower, box.lower[axis], tolerance) << "axis " << axis;
      ASSERT_NEAR(upper, box.lower[axis] + double(box.extent[axis]), tolerance) << "axis " << axis;
    }
  }

  void expectPatch(const LeafPatch& leaf, const Lanes& lanes, int lane) const {
    for (int c = 0; c < 4; c++) ASSERT_NEAR(lanes.z[c][lane], leaf.z[c], tolerance) << "corner " << c;
    ASSERT_NEAR(lanes.thickness[lane], leaf.thickness, tolerance);
    ASSERT_EQ((lanes.solid >> lane) & 1, size_t(leaf.solid));
    ASSERT_EQ((lanes.empty >> lane) & 1, size_t(leaf.empty));
  }
};

// Planes are multiples of 2^-12.
NodeBox coarseBox(Random& random) {
  NodeBox box;
  for (int axis = 0; axis < 3; axis++) {
    const int steps = 1 << 12, extent = int(random.magnitude(1, steps + 1));
    box.extent[axis] = float(extent) / float(steps);
    box.lower[axis] = float(random.below(uint32_t(steps - extent + 1))) / float(steps);
  }
  return box;
}

// A box up to seven levels below the root.
NodeBox anyBox(Random& random) {
  NodeBox box = rootBox();
  for (uint32_t i = random.below(8); i > 0; i--) box = decodeChild(random.bits(), int(random.below(4)), box);
  return box;
}

Heights heightsOf(uint64_t bits) { return {uint32_t(bits), uint32_t(bits >> 32)}; }

uint64_t randomHeights(Random& random) {
  uint64_t heights = uint64_t(random.bits()) << 32 | random.bits();
  if (!hasSeparateLeaves(heightsOf(heights))) return heights;
  for (int child = 0; child < 4; child++) {
    if (!random.chance(0.3)) continue;
    const uint64_t code = random.chance(0.5) ? solidLeaf : emptyLeaf;
    heights =
        (heights & ~(uint64_t(separateLeafMask) << (separateLeafBits * child))) | code << (separateLeafBits * child);
  }
  return heights;
}

template<typename MakeBox>
void compareNodes(uint32_t seed, const MakeBox& makeBox, double tolerance) {
  Random random(seed);
  for (int i = 0; i < 16000; i++) {
    const NodeBox parent = makeBox(random);
    const uint32_t word = random.bits();
    const Lanes lanes = decodeLanes(word, nullptr, parent, 4 * random.below(4));
    for (int lane = 0; lane < 4; lane++) {
      SCOPED_TRACE(testing::Message() << "node " << i << ", lane " << lane);
      Comparison{tolerance}.expectBox(decodeChild(word, lane, parent), lanes, lane);
      if (testing::Test::HasFailure()) return;
    }
  }
}

template<typename MakeBox>
void compareGroups(uint32_t seed, const MakeBox& makeBox, double tolerance) {
  Random random(seed);
  unsigned lattices = 0, separate = 0, solid = 0, empty = 0;
  for (int i = 0; i < 16000; i++) {
    const NodeBox parent = makeBox(random);
    const uint32_t word = random.bits();
    const uint64_t bits = randomHeights(random);
    const Heights heights = heightsOf(bits);
    (hasSeparateLeaves(heights) ? separate : lattices)++;
    const Lanes lanes = decodeLanes(word, &bits, parent, 4 * random.below(4));
    for (int lane = 0; lane < 4; lane++) {
      SCOPED_TRACE(testing::Message() << "group " << i << (hasSeparateLeaves(heights) ? ", separate" : ", lattice")
                                      << ", lane " << lane);
      const LeafPatch leaf = decodeLeaf(word, heights, lane, parent);
      solid += leaf.solid;
      empty += leaf.empty;
      Comparison{tolerance}.expectBox(leaf.box, lanes, lane);
      Comparison{tolerance}.expectPatch(leaf, lanes, lane);
      if (testing::Test::HasFailure()) return;
    }
  }
  for (unsigned count : {lattices, separate, solid, empty}) EXPECT_GT(count, 1000u);
}

TEST(SimdDecoding, IsCompiledForNamedIsa) { EXPECT_STREQ(ISA_STR, TEST_ISA); }

TEST(SimdDecoding, NodesMatchScalarDecodersWithoutRounding) { compareNodes(91, coarseBox, 0); }
TEST(SimdDecoding, NodesMatchWithinRoundingInAnyParent) { compareNodes(92, anyBox, maxRounding); }
TEST(SimdDecoding, GroupsMatchScalarDecodersWithoutRounding) { compareGroups(93, coarseBox, 0); }
TEST(SimdDecoding, GroupsMatchWithinRoundingInAnyParent) { compareGroups(94, anyBox, maxRounding); }

}} // namespace programs::test
