// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The variants of arithmetic to which a traversal may be compiled, as scalar code. They are all combinations of two
 * choices: fused or separate multiply and add, and a mirrored or original axis. A mirrored ray decodes 1-upper from the
 * mirrored parent, which rounds differently. */

#include "kernels/cbvh/paper/node_encoder.h"
#include "kernels/cbvh/paper/leaf/format.h"

#include <cmath>
#include <utility>

namespace programs::test {

using namespace embree::cbvh;

struct Form {
  bool fused, mirrored;
};
constexpr Form forms[4] = {{false, false}, {true, false}, {false, true}, {true, true}};

inline float madd(bool fused, float a, float b, float c) {
  if (fused) return std::fma(a, b, c);
  const volatile float product = a * b; // volatile prevents the compiler from fusing
  return product + c;
}

// Bounds that a traversal of one variant decodes; in mirrored coordinates if it mirrors.
inline NodeBox decode(Form form, uint32_t node, int child, const NodeBox& parent) {
  NodeBox box;
  for (int axis = 0; axis < 3; axis++) {
    float lower, upper;
    if (axis < 2) {
      lower = lowerPlane((node >> lowerShift(axis)) & planePairMask, childCoordinate(child, axis));
      upper = upperPlane((node >> upperShift(axis)) & planePairMask, childCoordinate(child, axis));
    } else {
      lower = zInterval(zCode(node, child)).lower;
      upper = zInterval(zCode(node, child)).upper;
    }
    if (form.mirrored) {
      std::swap(lower, upper);
      lower = 1 - lower;
      upper = 1 - upper;
    }
    box.lower[axis] = madd(form.fused, lower, parent.extent[axis], parent.lower[axis]);
    box.extent[axis] = madd(form.fused, upper, parent.extent[axis], parent.lower[axis]) - box.lower[axis];
  }
  return box;
}

// The outer planes of a lattice, with the height of its parent.
inline NodeBox decodeLattice(Form form, uint32_t word, const NodeBox& parent) {
  NodeBox box = parent;
  for (int axis = 0; axis < 2; axis++) {
    const uint32_t bits = word >> latticeShift(axis);
    float lower = latticeOuterOffset(bits & latticePlaneMask);
    float upper = latticeOuterOffset((bits >> 5) & latticePlaneMask);
    if (form.mirrored) std::swap(lower, upper);
    box.lower[axis] = madd(form.fused, lower, parent.extent[axis], parent.lower[axis]);
    box.extent[axis] = madd(form.fused, 1 - upper, parent.extent[axis], parent.lower[axis]) - box.lower[axis];
  }
  return box;
}

// True if `box` contains `exact`, which is not mirrored. Adds as traversal does.
inline bool contains(Form form, const NodeBox& box, const ExactBox& exact) {
  for (int axis = 0; axis < 3; axis++) {
    const double lower = form.mirrored ? 1 - exact.upper[axis] : exact.lower[axis];
    const double upper = form.mirrored ? 1 - exact.lower[axis] : exact.upper[axis];
    const volatile float decodedUpper = box.lower[axis] + box.extent[axis];
    if (!(double(box.lower[axis]) <= lower && upper <= double(decodedUpper))) return false;
  }
  return true;
}

} // namespace programs::test
