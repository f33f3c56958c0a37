// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A shader of an application that uses the names of our headers for its own purposes. It is compiled, not run. */

#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_shader_explicit_arithmetic_types : require

struct Range {
  int a;
};
struct Vector {
  float x;
};
struct Real {
  float value;
};
struct WordsAt {
  uint a;
};
float morton, isInside, wordAt, hitBox, hitLip;

#define CBVH_LEAF_KINDS kinds
layout(constant_id = 7) const uint kinds = 0xFFFFFFFFu;
#ifdef WITH_FLOAT64
#define CBVH_FLOAT64
#endif
#include <embree3/cbvh.glsl>

float minimum(float a) { return a; }
const int maxLevel = 3;
struct Wide {
  float value;
};
uint32_t referenceType(uint32_t a) { return a; }

layout(local_size_x = 64) in;
layout(push_constant) uniform Arguments { uvec2 scene; }
arguments;
layout(std430, binding = 0) buffer Out { float t[]; };

void main() {
  CbvhRay ray = CbvhRay(vec3(0.0), 0.0, vec3(0.0, 0.0, 1.0), 1e30, 0xFFFFFFFFu, 0.5);
  CbvhHit hit;
  uint i = gl_GlobalInvocationID.x;
  if (cbvhIntersect(arguments.scene, ray, hit))
    t[i] = minimum(hit.t) + float(hit.primID + hit.geomID + hit.instID) + hit.u + hit.v + hit.Ng.x;
  if (cbvhOccluded(arguments.scene, ray)) t[i] = float(referenceType(uint32_t(maxLevel)));
}
