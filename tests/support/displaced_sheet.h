// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Flat faces in a row, displaced by a function of the test. */

#include "support/scene.h"

namespace programs::test {

using DisplaceFunction = std::function<void(unsigned primID, float u, float v, Vec& p)>;

// A geometry of separate unit faces along x. `displace` must outlive its scene.
inline RTCGeometry newSheet(RTCDevice device, unsigned faces, float x0, float rate, DisplaceFunction& displace) {
  Cage cage;
  for (unsigned f = 0; f < faces; f++) {
    const float x = x0 + f;
    for (const Vec& p : {Vec{x, 0, 0}, Vec{x + 1, 0, 0}, Vec{x + 1, 1, 0}, Vec{x, 1, 0}}) cage.positions.push_back(p);
    cage.addFace({4 * f, 4 * f + 1, 4 * f + 2, 4 * f + 3});
  }
  cage.mode = RTC_SUBDIVISION_MODE_PIN_ALL;
  SurfaceSettings settings;
  settings.rate = rate;
  RTCGeometry geometry = newSurface(device, cage, settings);
  rtcSetGeometryUserData(geometry, &displace);
  rtcSetGeometryDisplacementFunction(geometry, [](const RTCDisplacementFunctionNArguments* args) {
    for (unsigned i = 0; i < args->N; i++) {
      Vec p = {args->P_x[i], args->P_y[i], args->P_z[i]};
      (*(DisplaceFunction*)args->geometryUserPtr)(args->primID, args->u[i], args->v[i], p);
      args->P_x[i] = p[0];
      args->P_y[i] = p[1];
      args->P_z[i] = p[2];
    }
  });
  return geometry;
}

inline void commit(RTCScene scene, RTCGeometry geometry) {
  rtcCommitGeometry(geometry);
  attach(scene, geometry);
  rtcCommitScene(scene);
}

} // namespace programs::test
