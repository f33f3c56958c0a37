// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Interpolation of vertices and planes in a segment, the time between two steps. */

#include "../base/vectors.h"

namespace embree::isa::cbvh {
/*! fraction: 0 at the beginning of the segment, 1 at its end. */
struct Interpolator {
  const vfloatV weightOfBegin, weightOfEnd;
  __forceinline explicit Interpolator(float fraction) : weightOfBegin(1.0f - fraction), weightOfEnd(fraction) {}

  /*! Rounds as Embree's lerp, so that vertices equal Embree's if the ends do. */
  __forceinline vfloatV operator()(const vfloatV& a, const vfloatV& b) const {
    return madd(weightOfBegin, a, weightOfEnd * b);
  }

  /*! Interpolates arrays, which must be aligned to vectors and padded to whole vectors. */
  __forceinline void interpolate(const float* a, const float* b, uint32_t count, float* out) const {
    for (uint32_t l = 0; l < count; l += vectorWidth)
      vfloatV::store(out + l, (*this)(vfloatV::load(a + l), vfloatV::load(b + l)));
  }
};
} // namespace embree::isa::cbvh
