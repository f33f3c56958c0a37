// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Decoded bounds contain the geometry on all levels, in every arithmetic to which a traversal may be compiled. */

#include "kernels/cbvh/paper/node_encoder.h"
#include "kernels/cbvh/paper/node_tables.cpp"
#include "support/decoding_forms.h"
#include "support/random.h"

#include <algorithm>
#include <vector>

namespace programs::test { namespace {

using namespace embree::cbvh;

constexpr int levels = 8;

ExactBox intersection(const ExactBox& a, const ExactBox& b) {
  ExactBox r;
  for (int axis = 0; axis < 3; axis++) {
    r.lower[axis] = std::min(std::max(a.lower[axis], b.lower[axis]), b.upper[axis]);
    r.upper[axis] = std::max(std::min(a.upper[axis], b.upper[axis]), r.lower[axis]);
  }
  return r;
}

// Arrangements of children.
enum Shape { QUADRANTS, FOLDED, NEEDLES, FLAT, POINTS, TOUCHING, SHAPES };

// Generates children of a parent whose geometry has the given exact bounds.
void makeChildren(Random& random, Shape shape, const NodeBox& parent, const ExactBox& exact, ExactBox children[4]) {
  for (int c = 0; c < 4; c++) {
    for (int axis = 0; axis < 3; axis++) {
      const double l = exact.lower[axis], e = exact.upper[axis] - l;
      double a = random.uniform(), b = random.uniform();
      switch (shape) {
      case QUADRANTS: // slightly more than the quadrant
        a = axis < 2 ? 0.5 * childCoordinate(c, axis) - 0.03 * random.uniform() : random.uniform(0, 0.5);
        b = axis < 2 ? a + 0.5 + 0.06 * random.uniform() : random.uniform(0.5, 1);
        break;
      case NEEDLES:
        if (axis != int(random.below(3))) b = a + random.magnitude(1e-9, 1e-2);
        break;
      case FLAT:
        if (axis == 2) b = a;
        break;
      case POINTS: b = a; break;
      default: break; // FOLDED: anywhere
      }
      double lower = l + e * std::min(a, b), upper = l + e * std::max(a, b);
      if (shape == TOUCHING) { // exactly on planes of some code
        const uint32_t pair = random.below(32);
        const int column = childCoordinate(c, axis == 2 ? 0 : axis);
        const Interval z = zInterval(random.below(8));
        lower = parent.lower[axis] + (axis == 2 ? z.lower : lowerPlane(pair, column)) * parent.extent[axis];
        upper = parent.lower[axis] + (axis == 2 ? z.upper : upperPlane(pair, column)) * parent.extent[axis];
        if (lower > upper) std::swap(lower, upper);
      }
      children[c].lower[axis] = lower;
      children[c].upper[axis] = upper;
    }
    children[c] = intersection(children[c], exact);
  }
}

// Moves bounds inwards by the slack that the encoder adds.
uint32_t encodeWithoutSlack(const NodeBox& parent, const ExactBox children[4]) {
  ExactBox moved[4];
  for (int c = 0; c < 4; c++)
    for (int axis = 0; axis < 3; axis++) {
      moved[c].lower[axis] = children[c].lower[axis] + containmentSlack;
      moved[c].upper[axis] = children[c].upper[axis] - containmentSlack;
    }
  return encodeNode(parent, moved);
}

// On one random path from the root to level 8. Returns how many children were not contained, over all variants.
template<typename Encode>
unsigned violations(Random& random, int shape, const Encode& encode) {
  ExactBox exact;
  for (int axis = 0; axis < 3; axis++) { // the margin of the frame is 2^-18
    exact.lower[axis] = 0x1p-18;
    exact.upper[axis] = 1 - 0x1p-18;
  }
  unsigned count = 0;
  NodeBox box[4] = {rootBox(), rootBox(), rootBox(), rootBox()};
  for (int level = 0; level < levels; level++) {
    ExactBox children[4];
    makeChildren(random, Shape(shape < SHAPES ? shape : int(random.below(SHAPES))), box[0], exact, children);
    const uint32_t node = encode(box[0], children);
    const int next = int(random.below(4));
    for (int f = 0; f < 4; f++) {
      for (int c = 0; c < 4; c++) count += !contains(forms[f], decode(forms[f], node, c, box[f]), children[c]);
      box[f] = decode(forms[f], node, next, box[f]);
    }
    exact = children[next];
  }
  return count;
}

TEST(NodeCodec, DecodedBoundsContainChildrenOnAllLevelsInAllArithmetic) {
  Random random(1);
  for (int shape = 0; shape <= SHAPES; shape++)
    for (int i = 0; i < 20000; i++)
      ASSERT_EQ(violations(random, shape, encodeNode), 0u) << "shape " << shape << ", path " << i;
}

// The opposite of the previous test: fused arithmetic rounds planes only once.
TEST(NodeCodec, GeometryTouchingPlanesIsLostWithoutSlack) {
  Random random(1);
  unsigned count = 0;
  for (int i = 0; i < 20000; i++) count += violations(random, TOUCHING, encodeWithoutSlack) != 0;
  EXPECT_GT(count, 100u);
}

TEST(NodeCodec, ReferenceDecoderIsOneOfTheVariants) {
  Random random(2);
  for (int i = 0; i < 10000; i++) {
    NodeBox parent;
    for (int axis = 0; axis < 3; axis++) {
      parent.lower[axis] = float(random.uniform());
      parent.extent[axis] = float(random.uniform()) * (1 - parent.lower[axis]);
    }
    const uint32_t node = random.bits();
    for (int c = 0; c < 4; c++) {
      const NodeBox a = decodeChild(node, c, parent), b = decode(forms[0], node, c, parent);
      for (int axis = 0; axis < 3; axis++) {
        ASSERT_EQ(a.lower[axis], b.lower[axis]);
        ASSERT_EQ(a.extent[axis], b.extent[axis]);
      }
    }
  }
}

// Rounding moves a plane by at most one ulp of numbers from 1 to 2 per level (node.h).
constexpr double stepError = 0x1p-23;

// A lower plane cannot round below its parent's, because the added term is not negative. An upper plane is the sum of
// two rounded numbers.
TEST(NodeCodec, BoundsNeverGrow) {
  Random random(3);
  for (int i = 0; i < 10000; i++) {
    NodeBox parent = rootBox();
    for (int level = 0; level < levels; level++) {
      const uint32_t node = random.bits();
      NodeBox boxes[4];
      for (int c = 0; c < 4; c++) {
        boxes[c] = decodeChild(node, c, parent);
        for (int axis = 0; axis < 3; axis++) {
          ASSERT_GE(boxes[c].lower[axis], parent.lower[axis]) << "level " << level;
          ASSERT_GE(boxes[c].extent[axis], 0) << "level " << level;
          ASSERT_LE(upperOf(boxes[c], axis), upperOf(parent, axis) + stepError) << "level " << level;
        }
      }
      parent = boxes[random.below(4)];
    }
  }
}

TEST(NodeCodec, EveryPlaneIsTightestWithSlack) {
  Random random(4);
  unsigned taken[8] = {}; // inner planes, by their codes
  for (int i = 0; i < 20000; i++) {
    ExactBox exact, children[4];
    for (int axis = 0; axis < 3; axis++) {
      exact.lower[axis] = 0x1p-18;
      exact.upper[axis] = 1 - 0x1p-18;
    }
    const NodeBox parent = rootBox();
    makeChildren(random, Shape(i % SHAPES), parent, exact, children);
    const uint32_t word = encodeNode(parent, children);
    SCOPED_TRACE(testing::Message() << "node " << i);
    for (int axis = 0; axis < 2; axis++)
      for (int column = 0; column < 2; column++) {
        double lower = 1, upper = 0;
        for (int c = 0; c < 4; c++)
          if (childCoordinate(c, axis) == column) {
            lower = std::min(lower, children[c].lower[axis]);
            upper = std::max(upper, children[c].upper[axis]);
          }
        const uint32_t lowerPair = (word >> lowerShift(axis)) & planePairMask,
                       upperPair = (word >> upperShift(axis)) & planePairMask;
        taken[column ? lowerPair >> 2 : upperPair >> 2]++;
        for (uint32_t other = 0; other < 32; other++) {
          if (lowerPlane(other, column) <= lower - containmentSlack) {
            ASSERT_LE(lowerPlane(other, column), lowerPlane(lowerPair, column));
          }
          if (upperPlane(other, column) >= upper + containmentSlack) {
            ASSERT_GE(upperPlane(other, column), upperPlane(upperPair, column));
          }
        }
      }
    for (int c = 0; c < 4; c++) {
      const Interval z = zInterval(zCode(word, c));
      for (uint32_t code = 0; code < 8; code++) {
        const Interval other = zInterval(code);
        if (other.lower <= children[c].lower[2] - containmentSlack &&
            other.upper >= children[c].upper[2] + containmentSlack) {
          ASSERT_LE(z.upper - z.lower, other.upper - other.lower);
        }
      }
    }
  }
  for (unsigned n : taken) EXPECT_GT(n, 20u);
}

// Children that fill their quadrants: a code loses at most one step of its table.
TEST(NodeCodec, RegularChildrenGetTightBounds) {
  ExactBox children[4];
  for (int c = 0; c < 4; c++)
    for (int axis = 0; axis < 3; axis++) {
      children[c].lower[axis] = 0.01 + (axis < 2 ? 0.49 * childCoordinate(c, axis) : 0.3);
      children[c].upper[axis] = children[c].lower[axis] + (axis < 2 ? 0.49 : 0.15);
    }
  const uint32_t node = encodeNode(rootBox(), children);
  for (int c = 0; c < 4; c++) {
    const NodeBox box = decodeChild(node, c, rootBox());
    EXPECT_LE(box.extent[0], 0.55f);
    EXPECT_LE(box.extent[1], 0.55f);
    EXPECT_LE(box.extent[2], 0.5f);
  }
}

// A box at a level below the root.
NodeBox randomBox(Random& random, int level) {
  NodeBox box = rootBox();
  for (int i = 0; i < level; i++) box = decodeChild(random.bits(), int(random.below(4)), box);
  return box;
}

TEST(NodeCodec, EveryFieldAffectsOnlyItsPlanes) {
  // changing a field changes bounds of the axis it belongs to and of no other
  Random random(6);
  for (int bit = 0; bit < 32; bit++)
    for (int level = 0; level < levels; level++) {
      const int axis = bit < 10 ? 0 : bit < 20 ? 1 : 2;
      const NodeBox parent = randomBox(random, level);
      const uint32_t node = random.bits();
      bool changed = false;
      for (int c = 0; c < 4; c++) {
        const NodeBox a = decodeChild(node, c, parent), b = decodeChild(node ^ (1u << bit), c, parent);
        for (int k = 0; k < 3; k++) {
          const bool differs = a.lower[k] != b.lower[k] || a.extent[k] != b.extent[k];
          if (k == axis) changed |= differs;
          else EXPECT_FALSE(differs) << "bit " << bit << ", child " << c << ", axis " << k << ", level " << level;
        }
      }
      EXPECT_TRUE(changed) << "bit " << bit << ", level " << level;
    }
}

// --- the tables of the traversal ---------------------------------------------------------

// Planes of a child from the tables, in the parent's extents.
void lookUp(const NodeTables& tables, uint32_t node, int child, float lower[3], float upper[3]) {
  for (int axis = 0; axis < 2; axis++) {
    lower[axis] = tables.lowerPlanes[axis][(node >> lowerShift(axis)) & planePairMask][child];
    upper[axis] = tables.upperPlanes[axis][(node >> upperShift(axis)) & planePairMask][child];
  }
  const float* z = tables.zPlanes[(node >> (zShift + 2 * zBits * (child >> 1))) & 63];
  lower[2] = z[child & 1];
  upper[2] = z[2 + (child & 1)];
}

struct Bounds {
  double lower[3], upper[3];
};

Bounds boundsOf(const NodeBox& box) {
  Bounds bounds;
  for (int axis = 0; axis < 3; axis++) {
    bounds.lower[axis] = box.lower[axis];
    bounds.upper[axis] = double(box.lower[axis]) + double(box.extent[axis]);
  }
  return bounds;
}

Bounds childByTables(const NodeTables& tables, uint32_t node, int c, const Bounds& parent) {
  float lower[3], upper[3];
  lookUp(tables, node, c, lower, upper);
  Bounds child;
  for (int axis = 0; axis < 3; axis++) {
    const double extent = parent.upper[axis] - parent.lower[axis];
    child.lower[axis] = parent.lower[axis] + double(lower[axis]) * extent;
    child.upper[axis] = parent.lower[axis] + double(upper[axis]) * extent;
  }
  return child;
}

// All planes are multiples of 1/256, so at the root both results are exact.
TEST(NodeTables, MatchScalarDecoderForAllCodes) {
  static const NodeTables tables;
  Random random(4);
  std::vector<uint32_t> nodes;
  for (int field = 0; field < 4; field++) // every code of every pair
    for (uint32_t code = 0; code < 32; code++) nodes.push_back(code << (field * planePairBits));
  for (uint32_t code = 0; code < 4096; code++) nodes.push_back(code << zShift); // every code of z
  for (int i = 0; i < 4096; i++) nodes.push_back(random.bits());

  for (uint32_t node : nodes)
    for (int child = 0; child < 4; child++) {
      const NodeBox box = decodeChild(node, child, rootBox());
      float lower[3], upper[3];
      lookUp(tables, node, child, lower, upper);
      for (int axis = 0; axis < 3; axis++) {
        ASSERT_EQ(lower[axis], box.lower[axis]) << std::hex << node << " child " << child;
        ASSERT_EQ(upper[axis], upperOf(box, axis)) << std::hex << node << " child " << child;
      }
    }
}

TEST(NodeTables, MasksOfFourExpandToMasksOfSixteen) {
  static const NodeTables tables;
  for (int mask = 0; mask < 16; mask++)
    for (int bit = 0; bit < 16; bit++) {
      const int isSet = (mask >> bit / 4) & 1;
      ASSERT_EQ((tables.firstOfFour[mask] >> bit) & 1, bit % 4 == 0 ? isSet : 0) << mask << " " << bit;
      ASSERT_EQ((tables.allOfFour[mask] >> bit) & 1, isSet) << mask << " " << bit;
    }
}

// Random paths reach parents that no word of the root describes. Three levels of multiples of 1/256 are floats,
// multiples of 2^-24 below 1: there both decoders are exact if the parent's upper plane is at most 1. Deeper,
// decodeChild has the error of one step per level.
TEST(NodeTables, MatchScalarDecoderOnPathsThroughAllLevels) {
  static const NodeTables tables;
  Random random(5);
  for (int path = 0; path < 4000; path++) {
    NodeBox parent = rootBox();
    Bounds exactParent = boundsOf(parent);
    for (int level = 1; level <= levels; level++) {
      const uint32_t node = random.bits();
      const int next = int(random.below(4));
      NodeBox nextBox = parent;
      Bounds nextExact = exactParent;
      for (int child = 0; child < 4; child++) {
        const NodeBox box = decodeChild(node, child, parent);
        const Bounds decoded = boundsOf(box), exact = childByTables(tables, node, child, exactParent);
        const double error = level <= 3 ? 0 : level * stepError;
        for (int axis = 0; axis < 3; axis++) {
          ASSERT_NEAR(decoded.lower[axis], exact.lower[axis], error)
              << std::hex << node << std::dec << " child " << child << " level " << level << " axis " << axis;
          ASSERT_NEAR(decoded.upper[axis], exact.upper[axis], error)
              << std::hex << node << std::dec << " child " << child << " level " << level << " axis " << axis;
        }
        if (child == next) {
          nextBox = box;
          nextExact = exact;
        }
      }
      parent = nextBox;
      exactParent = nextExact;
    }
  }
}

}} // namespace programs::test
