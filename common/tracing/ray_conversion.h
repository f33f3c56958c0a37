// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "tracing/denormals.h"
#include "tracing/ray.h"

#include <embree3/rtcore.h>

namespace programs {

inline void load(const Ray& ray, RTCRay& out) {
  out.org_x = ray.origin.x;
  out.org_y = ray.origin.y;
  out.org_z = ray.origin.z;
  out.tnear = ray.tnear;
  out.dir_x = ray.direction.x;
  out.dir_y = ray.direction.y;
  out.dir_z = ray.direction.z;
  out.time = ray.time;
  out.tfar = ray.tfar;
  out.mask = ~0u;
  out.id = 0;
  out.flags = 0;
}

/* Sets the hit to a miss. */
inline void load(const Ray& ray, RTCRayHit& out) {
  load(ray, out.ray);
  out.hit.Ng_x = out.hit.Ng_y = out.hit.Ng_z = out.hit.u = out.hit.v = 0.0f;
  out.hit.primID = out.hit.geomID = out.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
}

template<typename RTCRayN>
inline void load(const Ray& ray, RTCRayN& out, size_t i) {
  out.org_x[i] = ray.origin.x;
  out.org_y[i] = ray.origin.y;
  out.org_z[i] = ray.origin.z;
  out.tnear[i] = ray.tnear;
  out.dir_x[i] = ray.direction.x;
  out.dir_y[i] = ray.direction.y;
  out.dir_z[i] = ray.direction.z;
  out.time[i] = ray.time;
  out.tfar[i] = ray.tfar;
  out.mask[i] = ~0u;
  out.id[i] = 0;
  out.flags[i] = 0;
}

} // namespace programs
