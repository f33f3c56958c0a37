// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* The forms of arithmetic that a traversal may have been compiled to, as scalar code:
 * the product of two choices, multiply and add fused or not, and the axis mirrored or
 * not (a mirrored ray decodes 1-upper from the mirrored parent, which rounds
 * differently). */

#include "kernels/cbvh/framed/node_encoder.h"
#include "kernels/cbvh/framed/leaf/format.h"

#include <cmath>
#include <utility>

namespace cbvh::test {

using namespace embree::cbvh;

struct Form { bool fused, mirrored; };
constexpr Form forms[4] = {{false, false}, {true, false}, {false, true}, {true, true}};

inline float madd(bool fused, float a, float b, float c)
{
  if (fused) return std::fma(a, b, c);
  const volatile float product = a*b; // keeps the compiler from fusing by itself
  return product + c;
}

// What a traversal of one form decodes; in mirrored coordinates when it mirrors.
inline NodeBox decode(Form form, uint32_t node, int child, const NodeBox& parent)
{
  NodeBox box;
  for (int axis = 0; axis < 3; axis++) {
    float lower, upper;
    if (axis < 2) {
      lower = lowerPlane((node >> lowerShift(axis)) & planePairMask, childColumn(child, axis));
      upper = upperPlane((node >> upperShift(axis)) & planePairMask, childColumn(child, axis));
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

// The outer planes of a lattice; as high as its parent.
inline NodeBox decodeLattice(Form form, uint32_t word, const NodeBox& parent)
{
  NodeBox box = parent;
  for (int axis = 0; axis < 2; axis++) {
    const uint32_t bits = word >> latticeShift(axis);
    float lower = latticeOuter(bits & latticePlaneMask), upper = latticeOuter((bits >> 5) & latticePlaneMask);
    if (form.mirrored) std::swap(lower, upper);
    box.lower[axis] = madd(form.fused, lower, parent.extent[axis], parent.lower[axis]);
    box.extent[axis] = madd(form.fused, 1 - upper, parent.extent[axis], parent.lower[axis]) - box.lower[axis];
  }
  return box;
}

// Whether exact bounds lie inside decoded ones, with the sum that traversal takes.
inline bool contains(Form form, const NodeBox& box, const ExactBox& exact)
{
  for (int axis = 0; axis < 3; axis++) {
    const double lower = form.mirrored ? 1 - exact.upper[axis] : exact.lower[axis];
    const double upper = form.mirrored ? 1 - exact.lower[axis] : exact.upper[axis];
    const volatile float decodedUpper = box.lower[axis] + box.extent[axis];
    if (!(double(box.lower[axis]) <= lower && upper <= double(decodedUpper))) return false;
  }
  return true;
}

} // namespace cbvh::test
