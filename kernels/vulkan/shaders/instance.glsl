// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Transforms rays into the space of instances, which may move. */

#ifndef CBVH_INSTANCE_GLSL
#define CBVH_INSTANCE_GLSL

#include "ray.glsl"

/* An affine transform: the columns of a 3x4 matrix. */
struct CbvhTransform {
  vec3 x, y, z, translation;
};

CbvhTransform cbvhTransformOf(float m[12]) {
  return CbvhTransform(vec3(m[0], m[1], m[2]), vec3(m[3], m[4], m[5]), vec3(m[6], m[7], m[8]),
                       vec3(m[9], m[10], m[11]));
}

/* Inverts by Cramer's rule. */
CbvhTransform cbvhInverse(CbvhTransform t) {
  vec3 yz = cross(t.y, t.z), zx = cross(t.z, t.x), xy = cross(t.x, t.y);
  float rcp = 1.0 / dot(t.x, yz);
  vec3 a = yz * rcp, b = zx * rcp, c = xy * rcp; // rows
  return CbvhTransform(vec3(a.x, b.x, c.x), vec3(a.y, b.y, c.y), vec3(a.z, b.z, c.z),
                       -vec3(dot(a, t.translation), dot(b, t.translation), dot(c, t.translation)));
}

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer CbvhTransforms { CbvhTransform at[]; };

/* Sets `local` to the transform from world space to the instance's space at a time, which must be finite. Interpolates
 * the transforms of moving instances linearly, as Embree. Returns false outside of the instance's time range. */
bool cbvhWorldToLocal(GeometryData instance, float time, out CbvhTransform local) {
  local = cbvhTransformOf(instance.worldToLocal);
  if (instance.numSteps == 1u) return true;
  if (time < instance.begin || time > instance.end) return false;
  float steps = (time - instance.begin) / (instance.end - instance.begin) * float(instance.numSteps - 1u);
  uint before = min(uint(steps), instance.numSteps - 2u);
  float f = clamp(steps - float(before), 0.0, 1.0), e = 1.0 - f;
  CbvhTransform a = CbvhTransforms(instance.transforms).at[before],
                b = CbvhTransforms(instance.transforms).at[before + 1u];
  local = cbvhInverse(
      CbvhTransform(e * a.x + f * b.x, e * a.y + f * b.y, e * a.z + f * b.z, e * a.translation + f * b.translation));
  return true;
}

CbvhRay cbvhTransformed(CbvhTransform t, CbvhRay ray) {
  CbvhRay local = ray;
  local.origin = t.x * ray.origin.x + (t.y * ray.origin.y + (t.z * ray.origin.z + t.translation));
  local.direction = t.x * ray.direction.x + (t.y * ray.direction.y + t.z * ray.direction.z);
  return local;
}

#endif
