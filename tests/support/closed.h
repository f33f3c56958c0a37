// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A ball around the origin is closed, checked with rays from points near its center. */

#include "support/query_forms.h"

namespace programs::test {

// A ray through a point between a and b, often exactly a.
inline RTCRayHit rayFromMiddle(Random& random, const Vec& a, const Vec& b) {
  const double t = random.chance(0.3) ? 0 : random.uniform();
  Vec from, direction;
  for (int c = 0; c < 3; c++) {
    from[c] = float(0.1 * random.normal());
    direction[c] = float(a[c] + t * (b[c] - a[c])) - from[c];
  }
  return makeRay(from, direction);
}

inline void expectNoneMisses(RTCScene scene, const std::vector<RTCRayHit>& rays) {
  for (QueryForm form : {QueryForm::Single, QueryForm::Coherent8}) {
    size_t missed = 0;
    for (const RTCRayHit& hit : closestHits(scene, rays, form)) missed += !isHit(hit);
    EXPECT_EQ(missed, 0u) << nameOf(form);
  }
}

} // namespace programs::test
