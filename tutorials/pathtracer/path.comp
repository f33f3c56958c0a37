// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Adds the light of one path to each pixel's sum. */

#version 460

layout(constant_id = 0) const uint kinds = 0xFFFFFFFFu;
layout(constant_id = 1) const uint stackSize = 96u;
#define CBVH_LEAF_KINDS kinds
#define CBVH_STACK_SIZE stackSize
#include <embree3/cbvh.glsl>
#ifdef CBVH_RAY_QUERY
#define INTERSECT cbvhQueryIntersect
#define OCCLUDED cbvhQueryOccluded
#else
#define INTERSECT cbvhIntersect
#define OCCLUDED cbvhOccluded
#endif
#include "path.h"

layout(local_size_x = 8, local_size_y = 8) in; // square, because first rays of neighboring pixels are coherent

layout(push_constant, scalar) uniform Arguments { PathArguments arguments; };

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Sums { vec3 at[]; };

CbvhRay rayOf(vec3 origin, float tnear, vec3 direction, float time) {
  return CbvhRay(origin, tnear, direction, 1.0 / 0.0, 0xFFFFFFFFu, time);
}

ClosestHit closestHit(uvec2 scene, vec3 origin, float tnear, vec3 direction, float time) {
  CbvhHit hit;
  bool exists = INTERSECT(scene, rayOf(origin, tnear, direction, time), hit);
  return ClosestHit(exists, hit.t, hit.Ng);
}

bool isOccluded(uvec2 scene, vec3 origin, float tnear, vec3 direction, float time) {
  return OCCLUDED(scene, rayOf(origin, tnear, direction, time));
}

void main() {
  uint x = gl_GlobalInvocationID.x, y = arguments.firstRow + gl_GlobalInvocationID.y;
  PathView view = arguments.view;
  if (x >= view.width || y >= view.height) return;
  vec3 light = lightOfPath(arguments.scene, view, x, y, arguments.sampleIndex);
  Sums sums = Sums(arguments.sums);
  uint pixel = y * view.width + x;
  sums.at[pixel] = arguments.sampleIndex == 0u ? light : sums.at[pixel] + light;
}
