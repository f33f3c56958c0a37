// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A shader of an application whose own top level contains a compressed scene next to triangles. Rays are RTCRayHit;
 * triangles have the application's geomID. */

#version 460
#extension GL_GOOGLE_include_directive : require

#define CBVH_FLOAT64
#define CBVH_RAY_QUERY
#include <embree3/cbvh.glsl>

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Arguments {
  uvec2 scene;
  uvec2 topLevel;
  uvec2 rays;
  uint count;
  float offset; // position of the scene in the application's world, along x
}
arguments;

layout(buffer_reference, scalar, buffer_reference_align = 16) buffer Rays { float at[]; };

const uint triangleName = 1000u;

void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= arguments.count) return;
  Rays rays = Rays(arguments.rays);
  uint w = 20u * i;
  vec3 origin = vec3(rays.at[w], rays.at[w + 1u], rays.at[w + 2u]),
       direction = vec3(rays.at[w + 4u], rays.at[w + 5u], rays.at[w + 6u]);
  CbvhRay ray = CbvhRay(origin - vec3(arguments.offset, 0.0, 0.0), rays.at[w + 3u], direction, rays.at[w + 8u],
                        floatBitsToUint(rays.at[w + 9u]), rays.at[w + 7u]);

  CbvhNearestHit found = cbvhNoHit(ray);
  rayQueryEXT query;
  rayQueryInitializeEXT(query, accelerationStructureEXT(arguments.topLevel), gl_RayFlagsNoneEXT, 0xFFu, origin,
                        ray.tnear, direction, min(ray.tfar, 3.0e38));
  while (rayQueryProceedEXT(query))
    if (rayQueryGetIntersectionTypeEXT(query, false) == gl_RayQueryCandidateIntersectionAABBEXT)
      cbvhIntersectCandidate(query, arguments.scene, ray, found);
    else rayQueryConfirmIntersectionEXT(query);

  uint type = rayQueryGetIntersectionTypeEXT(query, true);
  if (type == gl_RayQueryCommittedIntersectionNoneEXT) return;
  rays.at[w + 8u] = rayQueryGetIntersectionTEXT(query, true);
  rays.at[w + 18u] = uintBitsToFloat(triangleName);
  if (type != gl_RayQueryCommittedIntersectionGeneratedEXT) return;
  CbvhHit hit = cbvhGetHit(found);
  rays.at[w + 8u] = hit.t;
  rays.at[w + 17u] = uintBitsToFloat(hit.primID);
  rays.at[w + 18u] = uintBitsToFloat(hit.geomID);
  rays.at[w + 19u] = uintBitsToFloat(hit.instID);
}
