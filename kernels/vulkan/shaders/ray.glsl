// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays and hits.
 *
 * Intersecting functions return true and update `hit` if they find a hit nearer than hit.t, or one at the same
 * distance that replaces it. If anyHit, a compile-time constant, is true, they return at the first hit. */

#ifndef CBVH_RAY_GLSL
#define CBVH_RAY_GLSL

#include "memory.glsl"
#include "../../cbvh/paper/local_ray.h"

/* A ray, as RTCRay. tnear and tfar are multiples of the direction, which need not be normalized. tnear < 0 counts as 0.
 * Rays with tnear > tfar and rays whose origin or direction is not finite hit nothing. A ray hits geometries whose mask
 * shares a bit with its own, at `time` in [0,1]. */
struct CbvhRay {
  vec3 origin;
  float tnear;
  vec3 direction;
  float tfar;
  uint mask;
  float time;
};

/* A ray with all bits of the mask, at time 0. */
CbvhRay cbvhMakeRay(vec3 origin, float tnear, vec3 direction, float tfar) {
  return CbvhRay(origin, tnear, direction, tfar, 0xFFFFFFFFu, 0.0);
}

/* A hit, as RTCHit, and its distance. In an instance, Ng is in the space of the instanced scene. */
struct CbvhHit {
  float t;
  float u, v;
  vec3 Ng;
  uint primID, geomID, instID; // CBVH_INVALID_ID without a hit
};

const uint CBVH_INVALID_ID = 0xFFFFFFFFu;

/* A ray in the space of the traversed scene or instance. */
struct CbvhPreparedRay {
  vec3 org, dir;
  vec3 rcp;     // reciprocals of the direction, finite
  float tnear;  // not negative
  float tfar;   // end of the ray, independent of hits
  float entryT; // distance at which the ray enters the current leaf's bounds; hits may be slightly nearer
  uint mask;
  float time;         // cbvhFiniteTime of the ray's time
  uint instID;        // instance that is being traversed, or CBVH_INVALID_ID
  uint firstGeometry; // index in SceneData::geometries of geometry 0 of the traversed scene
};

/* directionReciprocal of kernels/cvert/rule/reciprocal.h, but keeps the sign of zero. */
float cbvhReciprocal(float d, float largest) {
  float size = min(max(abs(d), max(1e-18 * largest, 1.17549435e-38)), 4.25352959e37);
  return 1.0 / (floatBitsToUint(d) >> 31 != 0u ? -size : size);
}

bool cbvhIsFinite(vec3 v) { return all(lessThan(floatBitsToUint(v) & uvec3(0x7FFFFFFFu), uvec3(0x7F800000u))); }
bool cbvhIsNumber(float x) { return (floatBitsToUint(x) & 0x7FFFFFFFu) <= 0x7F800000u; }

/* A ray's time, or a time before all motion if it is not finite. */
float cbvhFiniteTime(float time) { return (floatBitsToUint(time) & 0x7F800000u) != 0x7F800000u ? time : -3.0e38; }

/* False if the ray cannot hit anything. Tests bits, because shader compilers assume finite numbers. */
bool cbvhMayHit(CbvhRay ray) {
  return cbvhIsFinite(ray.origin) && cbvhIsFinite(ray.direction) && cbvhIsNumber(ray.tnear) && cbvhIsNumber(ray.tfar) &&
         ray.tnear <= ray.tfar && ray.tfar >= 0.0;
}

CbvhPreparedRay cbvhPreparedRay(CbvhRay ray) {
  CbvhPreparedRay prepared;
  prepared.org = ray.origin;
  prepared.dir = ray.direction;
  vec3 size = abs(ray.direction);
  float largest = max(size.x, max(size.y, size.z));
  for (int k = 0; k < 3; k++) prepared.rcp[k] = cbvhReciprocal(ray.direction[k], largest);
  prepared.tnear = prepared.entryT = max(ray.tnear, 0.0);
  prepared.tfar = ray.tfar;
  prepared.mask = ray.mask;
  prepared.time = cbvhFiniteTime(ray.time);
  prepared.instID = CBVH_INVALID_ID;
  prepared.firstGeometry = 0u;
  return prepared;
}

/* True if the masks of the ray and the geometry share a bit. */
bool cbvhIsVisible(SceneData scene, CbvhPreparedRay ray, uint geomID) {
  return (CbvhGeometries(scene.geometries).at[ray.firstGeometry + geomID].mask & ray.mask) != 0u;
}

void cbvhSetHit(inout CbvhHit hit, CbvhPreparedRay ray, float t, float u, float v, vec3 Ng, uint primID, uint geomID) {
  hit.t = t;
  hit.u = u;
  hit.v = v;
  hit.Ng = Ng;
  hit.primID = primID;
  hit.geomID = geomID;
  hit.instID = ray.instID;
}

#endif
