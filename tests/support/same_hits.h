// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compares hits of diced geometry with those of Embree's own kernel, on the ISA of the test. */

#include "support/query_forms.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace programs::test {

template<typename Diced>
std::vector<RTCRayHit> raysAt(Random& random, const Diced& diced, unsigned count) {
  std::vector<RTCRayHit> rays;
  for (unsigned i = 0; i < count; i++) rays.push_back(rayAt(random, diced));
  return rays;
}

inline double angleBetween(const RTCHit& a, const RTCHit& b) {
  const double dot = double(a.Ng_x) * b.Ng_x + double(a.Ng_y) * b.Ng_y + double(a.Ng_z) * b.Ng_z;
  const auto square = [](const RTCHit& h) {
    return double(h.Ng_x) * h.Ng_x + double(h.Ng_y) * h.Ng_y + double(h.Ng_z) * h.Ng_z;
  };
  return std::acos(std::min(1.0, dot / std::sqrt(square(a) * square(b))));
}

inline double cosine(const RTCRayHit& r) {
  const double d[3] = {r.ray.dir_x, r.ray.dir_y, r.ray.dir_z}, n[3] = {r.hit.Ng_x, r.hit.Ng_y, r.hit.Ng_z};
  const auto dot = [](const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; };
  return std::fabs(dot(d, n)) / std::sqrt(dot(d, d) * dot(n, n));
}

// slack: tolerance of parameters for rays that do not graze. maxOthers: number of rays that may hit another primitive
// or none, because they graze an edge, where floats differ.
inline void expectSameHits(const std::vector<RTCRayHit>& expected, const std::vector<RTCRayHit>& found,
                           double slack = 1e-4, size_t maxOthers = 0) {
  size_t others = 0;
  ASSERT_EQ(expected.size(), found.size());
  for (size_t i = 0; i < expected.size(); i++) {
    SCOPED_TRACE(testing::Message() << "ray " << i);
    const RTCRayHit &e = expected[i], &f = found[i];
    if (others < maxOthers && (isHit(e) != isHit(f) || e.hit.primID != f.hit.primID)) {
      others++;
      continue;
    }
    ASSERT_EQ(isHit(e), isHit(f));
    if (!isHit(e)) continue;
    ASSERT_EQ(e.hit.geomID, f.hit.geomID);
    ASSERT_EQ(e.hit.primID, f.hit.primID);
    ASSERT_EQ(e.hit.instID[0], f.hit.instID[0]);
    // floats are less accurate along a grazing ray
    const double grazing = std::max(1.0, 0.1 / cosine(e));
    ASSERT_NEAR(e.ray.tfar, f.ray.tfar, 1e-5 * e.ray.tfar * grazing);
    ASSERT_NEAR(e.hit.u, f.hit.u, slack * grazing);
    ASSERT_NEAR(e.hit.v, f.hit.v, slack * grazing);
    ASSERT_LT(angleBetween(e.hit, f.hit), 1e-3);
  }
}

// The same with every query. Also expects that any hit agrees with the closest one.
inline void expectSameQueries(RTCScene embree, RTCScene scene, const std::vector<RTCRayHit>& rays, double slack = 1e-4,
                              size_t maxOthers = 0) {
  for (QueryForm form : allQueryForms) {
    SCOPED_TRACE(nameOf(form));
    const std::vector<RTCRayHit> found = closestHits(scene, rays, form), any = anyHits(scene, rays, form);
    ASSERT_NO_FATAL_FAILURE(expectSameHits(closestHits(embree, rays, form), found, slack, maxOthers));
    for (size_t i = 0; i < rays.size(); i++)
      ASSERT_EQ(any[i].ray.tfar, isHit(found[i]) ? -INFINITY : rays[i].ray.tfar) << "ray " << i;
  }
}

// Names tests after the ISA in a device string "isa=...".
inline std::string nameOfIsa(const testing::TestParamInfo<const char*>& info) {
  std::string name;
  for (char c : std::string(info.param).substr(4))
    if (c != '.') name += c;
  return name;
}

} // namespace programs::test
