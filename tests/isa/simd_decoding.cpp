// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The traversal's decoders of nodes and of cLEAF's groups, lane for lane against the scalar
 * ones, codec/node.h and codec/leaf.h: random words, random parents, all mirrorings. Compiled
 * once for every ISA, outside of the library.
 *
 * Where all planes of a parent are multiples of 2^-12 nothing rounds: planes of nodes are
 * multiples of 1/256 of their parent's extent and those of lattices of 1/1024, heights are
 * odd multiples of 3/512 of the parent's in a lattice, and of 1/32 of a child's, itself a
 * multiple of 1/32 of the parent's, in loose leaves. The finest of these are multiples of
 * 2^-22 below 2, which a float holds. There the two must be equal to the last bit, fused or
 * not. Anywhere else they may round another way, by no more than maxRounding. */

#include "kernels/cbvh/trace/group_patches4.h"
#include "support/random.h"

// for isa_check.cpp
extern const char* const programIsa;
const char* const programIsa = TEST_ISA;

namespace cbvh::test {
namespace {

using namespace embree::cbvh;

// --- the kernels' decoders -----------------------------------------------------------

// What they say of four lanes, in mirrored coordinates.
struct Lanes
{
  float lower[3][4], extent[3][4];
  float z[4][4]; // at corners column + 2 row of the boxes, then lanes
  float thickness[4];
  size_t solid, empty;
};

// The one place that names their classes. flips: of x, y and z, bits 0 to 2; parent: mirrored;
// groups: the heights of several groups, as a block stores them, or nullptr for a node, which
// has no more than boxes.
Lanes decodeLanes(int flips, uint32_t word, const uint64_t* groups, uint32_t group, const NodeBox& parent)
{
  using namespace embree;
  using namespace embree::isa::cbvh;
  LocalRay local;
  local.P0 = vfloat4(flips & 1 ? 1.0f : 0.0f, flips & 2 ? 1.0f : 0.0f, flips & 4 ? 1.0f : 0.0f, 0.0f);
  local.P1 = vfloat4(1.0f) - local.P0;
  local.epsilon = vfloat4(0.0f);
  const MirroredRay ray(local);
  ParentBox box;
  for (int axis = 0; axis < 3; axis++) { box.lower[axis] = vfloat4(parent.lower[axis]); box.extent[axis] = vfloat4(parent.extent[axis]); }
  ChildBoxes boxes;
  Lanes lanes = {};
  if (groups) {
    GroupPatches patches;
    patches.decode(word, groups[group], box, ray, boxes);
    for (int c = 0; c < 4; c++) vfloat4::storeu(lanes.z[c], patches.z(vfloat4(float(c & 1)), vfloat4(float(c >> 1))));
    vfloat4::storeu(lanes.thickness, patches.reach + patches.reach);
    lanes.solid = patches.solid;
    lanes.empty = patches.empty;
  } else {
    ray.decode(word, box, boxes);
  }
  for (int axis = 0; axis < 3; axis++) {
    vfloat4::storeu(lanes.lower[axis], boxes.lower[axis]);
    vfloat4::storeu(lanes.extent[axis], boxes.extent[axis]);
  }
  return lanes;
}

// --- comparison ----------------------------------------------------------------------

/* Roundings that may differ, each of half an ulp of a number below 2, 2^-24, at most. A plane
 * of a box: the mirrored parent's lower plane, and on either side the product, the sum and the
 * extent, 7. A height: besides, on either side, the bins' origin, their size times up to 128
 * of them, which is a relative error of a number below 2, their thickness, and, in a loose leaf,
 * three of these at the fourth corner: less than 32. */
constexpr double maxRounding = 32*0x1p-24;

struct Comparison
{
  int flips;
  double tolerance;

  // Upper and lower swap where an axis is mirrored. A lattice that some random word puts above
  // or below its parent's box, as no encoder does, has a box of no height, on either side of
  // the parent: which depends on the mirroring.
  void expectBox(const NodeBox& box, const Lanes& lanes, int lane) const
  {
    for (int axis = 0; axis < 3; axis++) {
      if (axis == 2 && box.extent[2] == 0) { ASSERT_NEAR(lanes.extent[2][lane], 0, tolerance); continue; }
      const bool flip = (flips >> axis) & 1;
      const double lower = box.lower[axis], upper = lower + double(box.extent[axis]);
      const double decodedLower = lanes.lower[axis][lane], decodedUpper = decodedLower + double(lanes.extent[axis][lane]);
      ASSERT_NEAR(decodedLower, flip ? 1 - upper : lower, tolerance) << "axis " << axis;
      ASSERT_NEAR(decodedUpper, flip ? 1 - lower : upper, tolerance) << "axis " << axis;
    }
  }

  void expectPatch(const LeafPatch& leaf, const Lanes& lanes, int lane) const
  {
    for (int c = 0; c < 4; c++) {
      const double z = leaf.z[c ^ (flips & 3)];
      ASSERT_NEAR(lanes.z[c][lane], flips & 4 ? 1 - z : z, tolerance) << "corner " << c;
    }
    ASSERT_NEAR(lanes.thickness[lane], leaf.thickness, tolerance);
    ASSERT_EQ((lanes.solid >> lane) & 1, size_t(leaf.solid));
    ASSERT_EQ((lanes.empty >> lane) & 1, size_t(leaf.empty));
  }
};

NodeBox mirror(const NodeBox& box, int flips)
{
  NodeBox mirrored = box;
  for (int axis = 0; axis < 3; axis++)
    if ((flips >> axis) & 1) mirrored.lower[axis] = float(1 - (double(box.lower[axis]) + double(box.extent[axis])));
  return mirrored;
}

// With planes at multiples of 2^-12.
NodeBox coarseBox(Random& random)
{
  NodeBox box;
  for (int axis = 0; axis < 3; axis++) {
    const int steps = 1 << 12, extent = int(random.magnitude(1, steps + 1));
    box.extent[axis] = float(extent)/float(steps);
    box.lower[axis] = float(random.below(uint32_t(steps - extent + 1)))/float(steps);
  }
  return box;
}

// A box up to seven levels below the root.
NodeBox anyBox(Random& random)
{
  NodeBox box = rootBox();
  for (uint32_t i = random.below(8); i > 0; i--) box = decodeChild(random.bits(), int(random.below(4)), box);
  return box;
}

Heights heightsOf(uint64_t bits) { return {uint32_t(bits), uint32_t(bits >> 32)}; }

uint64_t randomHeights(Random& random)
{
  uint64_t heights = uint64_t(random.bits()) << 32 | random.bits();
  if (!isLoose(heightsOf(heights))) return heights;
  for (int child = 0; child < 4; child++) {
    if (!random.chance(0.3)) continue;
    const uint64_t code = random.chance(0.5) ? solidLeaf : emptyLeaf;
    heights = (heights & ~(uint64_t(looseMask) << (looseBits*child))) | code << (looseBits*child);
  }
  return heights;
}

template<typename MakeBox>
void compareNodes(uint32_t seed, const MakeBox& makeBox, double tolerance)
{
  Random random(seed);
  for (int i = 0; i < 4000; i++) {
    const NodeBox parent = makeBox(random);
    const uint32_t word = random.bits();
    for (int flips = 0; flips < 8; flips++) {
      const Lanes lanes = decodeLanes(flips, word, nullptr, 0, mirror(parent, flips));
      for (int lane = 0; lane < 4; lane++) {
        SCOPED_TRACE(testing::Message() << "node " << i << ", flips " << flips << ", lane " << lane);
        Comparison{flips, tolerance}.expectBox(decodeChild(word, lane ^ (flips & 3), parent), lanes, lane);
        if (testing::Test::HasFatalFailure()) return;
      }
    }
  }
}

template<typename MakeBox>
void compareGroups(uint32_t seed, const MakeBox& makeBox, double tolerance)
{
  Random random(seed);
  unsigned lattices = 0, loose = 0, solid = 0, empty = 0;
  for (int i = 0; i < 4000; i++) {
    const NodeBox parent = makeBox(random);
    const uint32_t word = random.bits();
    uint64_t groups[3];
    for (uint64_t& heights : groups) heights = randomHeights(random);
    const uint32_t group = random.below(3);
    (isLoose(heightsOf(groups[group])) ? loose : lattices)++;
    for (int flips = 0; flips < 8; flips++) {
      const Lanes lanes = decodeLanes(flips, word, groups, group, mirror(parent, flips));
      for (int lane = 0; lane < 4; lane++) {
        SCOPED_TRACE(testing::Message() << "group " << i << (isLoose(heightsOf(groups[group])) ? ", loose" : ", lattice") << ", flips " << flips << ", lane " << lane);
        const LeafPatch leaf = decodeLeaf(word, heightsOf(groups[group]), lane ^ (flips & 3), parent);
        solid += leaf.solid;
        empty += leaf.empty;
        Comparison{flips, tolerance}.expectBox(leaf.box, lanes, lane);
        Comparison{flips, tolerance}.expectPatch(leaf, lanes, lane);
        if (testing::Test::HasFatalFailure()) return;
      }
    }
  }
  for (unsigned count : {lattices, loose, solid, empty}) EXPECT_GT(count, 1000u);
}

TEST(SimdDecoding, IsCompiledForTheIsaOfItsName) { EXPECT_STREQ(ISA_STR, TEST_ISA); }

TEST(SimdDecoding, NodesEqualTheScalarDecodersWhereNothingRounds) { compareNodes(91, coarseBox, 0); }
TEST(SimdDecoding, NodesDifferByRoundingOnlyInAnyParent)          { compareNodes(92, anyBox, maxRounding); }
TEST(SimdDecoding, GroupsEqualTheScalarDecodersWhereNothingRounds) { compareGroups(93, coarseBox, 0); }
TEST(SimdDecoding, GroupsDifferByRoundingOnlyInAnyParent)          { compareGroups(94, anyBox, maxRounding); }

} // namespace
} // namespace cbvh::test
