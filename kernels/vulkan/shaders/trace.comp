// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Traces a buffer of rays, a ray per invocation: RTCRayHit for the closest hit, or RTCRay for any hit if CBVH_ANY_HIT
 * is defined. CBVH_RAY_QUERY selects ray queries. host/scene.cpp records dispatches of this shader. */

#version 460

layout(constant_id = 0) const uint kinds = 0xFFFFFFFFu;
layout(constant_id = 1) const uint stackSize = 96u;
#define CBVH_LEAF_KINDS kinds
#define CBVH_STACK_SIZE stackSize
#include "cbvh.glsl"

#ifdef CBVH_RAY_QUERY
#define INTERSECT cbvhQueryIntersect
#define OCCLUDED cbvhQueryOccluded
#else
#define INTERSECT cbvhIntersect
#define OCCLUDED cbvhOccluded
#endif

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform Arguments {
  uvec2 scene;
  uvec2 rays;
  uvec2 order;       // address of pairs (key, index of a ray), or 0
  uint first, count; // index of the first ray or pair, number of rays
}
arguments;

/* Layout of RTCRay and RTCRayHit, in words. */
#ifdef CBVH_ANY_HIT
const uint stride = 12u;
#else
const uint stride = 20u;
#endif
const uint tfarWord = 8u, hitWord = 12u;

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer RaysIn { vec4 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Rays { uint at[]; };

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= arguments.count) return;
  i += arguments.first;
  if (arguments.order != uvec2(0u)) i = CbvhPairs(arguments.order).at[i].y;
  uint word = stride * i;
  vec4 a = RaysIn(arguments.rays).at[word >> 2], b = RaysIn(arguments.rays).at[(word >> 2) + 1u],
       c = RaysIn(arguments.rays).at[(word >> 2) + 2u];
  CbvhRay ray = CbvhRay(a.xyz, a.w, b.xyz, c.x, floatBitsToUint(c.y), b.w);
  Rays rays = Rays(arguments.rays);
#ifdef CBVH_ANY_HIT
  if (OCCLUDED(arguments.scene, ray)) rays.at[word + tfarWord] = floatBitsToUint(-1.0 / 0.0);
#else
  CbvhHit hit;
  if (!INTERSECT(arguments.scene, ray, hit)) return;
  rays.at[word + tfarWord] = floatBitsToUint(hit.t);
  rays.at[word + hitWord] = floatBitsToUint(hit.Ng.x);
  rays.at[word + hitWord + 1u] = floatBitsToUint(hit.Ng.y);
  rays.at[word + hitWord + 2u] = floatBitsToUint(hit.Ng.z);
  rays.at[word + hitWord + 3u] = floatBitsToUint(hit.u);
  rays.at[word + hitWord + 4u] = floatBitsToUint(hit.v);
  rays.at[word + hitWord + 5u] = hit.primID;
  rays.at[word + hitWord + 6u] = hit.geomID;
  rays.at[word + hitWord + 7u] = hit.instID;
#endif
}
