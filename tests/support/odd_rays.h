// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Rays that are not finite, and rays along axes, which miss boxes unless zeros in directions are handled exactly. */

#include "support/random.h"
#include "support/vertex_recorder.h"

#include <algorithm>

namespace programs::test {

// Sets components of a ray's origin or direction to NaN or infinity, or tnear or tfar to NaN.
inline void spoil(RTCRay& ray, Random& random) {
  const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
  float* const fields[] = {&ray.org_x, &ray.org_y, &ray.org_z, &ray.dir_x,
                           &ray.dir_y, &ray.dir_z, &ray.tnear, &ray.tfar};
  const float values[] = {nan, infinity, -infinity};
  if (random.chance(0.1)) { // all components of the origin or of the direction
    const unsigned first = 3 * random.below(2);
    for (unsigned k = 0; k < 3; k++) *fields[first + k] = nan;
    return;
  }
  for (unsigned n = 1 + random.below(3); n > 0; n--) {
    const unsigned k = random.below(8);
    *fields[k] = k < 6 ? values[random.below(3)] : nan;
  }
}

struct AllVertices : public VertexRecorder {
  std::vector<Vec> vertices;
  void record(const RTCDisplacementFunctionNArguments& args) override {
    for (unsigned i = 0; i < args.N; i++) vertices.push_back({args.P_x[i], args.P_y[i], args.P_z[i]});
  }

  // In an order that does not depend on threads.
  std::vector<Vec> taken() {
    std::sort(vertices.begin(), vertices.end());
    return vertices;
  }
};

// A ray from inside the cube close to a vertex, where bounds of blocks end: along an axis, nearly so, or in the plane
// of two axes.
inline RTCRayHit rayNextToVertex(Random& random, const std::vector<Vec>& vertices) {
  const unsigned across = random.below(3), other = (across + 1 + random.below(2)) % 3, zeros = 1 + random.below(2);
  while (true) {
    const Vec& v = vertices[random.below(uint32_t(vertices.size()))];
    if (std::fabs(v[across]) > 0.25f || (zeros == 2 && std::fabs(v[other]) > 0.25f)) continue;
    Vec o, d;
    for (unsigned k = 0; k < 3; k++) {
      const bool isZero = k == across || (zeros == 2 && k == other);
      const float aside = float(random.magnitude(1e-8, 1e-5)),
                  tilt = random.chance(0.3) ? float(random.magnitude(1e-14, 1e-7)) : 0;
      o[k] = isZero ? v[k] + (random.chance(0.5) ? aside : -aside) : float(random.uniform(-0.2, 0.2));
      d[k] = isZero ? (random.chance(0.5) ? tilt : -tilt) : v[k] - o[k];
    }
    return makeRay(o, d);
  }
}

inline std::vector<RTCRayHit> raysNextToVertices(Random& random, const std::vector<Vec>& vertices, unsigned count) {
  std::vector<RTCRayHit> rays;
  for (unsigned i = 0; i < count; i++) rays.push_back(rayNextToVertex(random, vertices));
  return rays;
}

// Exponents of powers of two from 1.4e-20 to 0.6e18. Scaling a direction by them is exact.
constexpr int oddExponents[] = {-66, -60, -50, -40, -30, -20, -10, 0, 20, 40, 59};

inline std::vector<RTCRayHit> withDirections(std::vector<RTCRayHit> rays, float scale) {
  for (RTCRayHit& ray : rays)
    for (float* d : {&ray.ray.dir_x, &ray.ray.dir_y, &ray.ray.dir_z}) *d *= scale;
  return rays;
}

} // namespace programs::test
