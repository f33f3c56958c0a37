// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* For ray queries and intersection shaders: intersects the leaves whose boxes the driver finds. cbvh.glsl explains the
 * use. */

#ifndef CBVH_RAY_QUERY_GLSL
#define CBVH_RAY_QUERY_GLSL

#extension GL_EXT_ray_query : require

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer CbvhPlacedBoxes { PlacedBoxes at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer CbvhLeafBoxes { LeafBox at[]; };

/* The nearest hit in leaves so far. If the query committed a nearer hit of another kind (cbvhIntersectCandidate), hit.t
 * is its distance. The other members still describe the hit in a leaf. */
struct CbvhNearestHit {
  CbvhHit hit;
  vec2 framed; // see cbvhReport
  CbvhVertNearest nearest;
};

CbvhNearestHit cbvhNoHit(CbvhRay ray) {
  CbvhHit none = CbvhHit(ray.tfar, 0.0, 0.0, vec3(0.0), CBVH_INVALID_ID, CBVH_INVALID_ID, CBVH_INVALID_ID);
  return CbvhNearestHit(none, vec2(-1.0), cbvhNoVertNearest());
}

/* Returns the nearest hit. Call it after intersecting all candidates. */
CbvhHit cbvhGetHit(CbvhNearestHit found) {
  CbvhHit hit = found.hit;
  if (hit.t == found.framed.x) hit.t = found.framed.y;
  return hit;
}

/* Returns false if the ray misses the leaf's exact box between its tnear and `tfar`, the distance of the nearest hit.
 * Tests as cbvhSortChildren. The driver's box is larger. Sets ray.entryT. */
bool cbvhIntersectsLeaf(LeafBox box, float tfar, inout CbvhPreparedRay ray) {
  float enter = ray.tnear, leave = tfar;
  for (int k = 0; k < 3; k++) {
    float a = (box.lower[k] - ray.org[k]) * ray.rcp[k], b = (box.upper[k] - ray.org[k]) * ray.rcp[k];
    enter = max(enter, min(a, b));
    leave = min(leave, max(a, b));
  }
  enter *= cbvhNearFactor;
  ray.entryT = cbvhEntryOfKey(floatBitsToUint(enter));
  return enter <= leave * cbvhFarFactor;
}

/* Intersects the leaf of a box. Returns true and updates `found` if it finds a hit nearer than found.hit.t, or one at
 * the same distance that replaces it. address: of the scene. customIndex: of the instance. box: index of the
 * primitive. ray: in the scene's space, with the same tfar in all calls with `found`. anyHit: see ray.glsl. */
bool cbvhIntersectBox(uvec2 address, uint customIndex, uint box, CbvhRay ray, const bool anyHit,
                      inout CbvhNearestHit found) {
  if (!cbvhMayHit(ray)) return false;
  SceneData scene = CbvhSceneAt(address).scene;
  PlacedBoxes place = CbvhPlacedBoxes(scene.placed).at[customIndex];
  LeafBox leaf = CbvhLeafBoxes(place.boxes).at[box];
  CbvhRay local = ray;
  if (cbvhHasKind(instanceReferenceType) && place.instID != CBVH_INVALID_ID) {
    GeometryData instance = CbvhGeometries(scene.geometries).at[place.instID];
    CbvhTransform toLocal;
    if ((instance.mask & ray.mask) == 0u) return false;
    if (!cbvhWorldToLocal(instance, cbvhFiniteTime(ray.time), toLocal)) return false;
    local = cbvhTransformed(toLocal, ray);
    if (!cbvhMayHit(local)) return false;
  }
  CbvhPreparedRay prepared = cbvhPreparedRay(local);
  prepared.instID = place.instID;
  prepared.firstGeometry = place.firstGeometry;
  if (!cbvhIntersectsLeaf(leaf, found.hit.t, prepared)) return false;
  return cbvhTraceLeaf(scene, prepared, leaf.reference, anyHit, found.hit, found.framed, found.nearest);
}

/* Intersects the query's current candidate, which must be a box of the scene. ray: the query's ray, transformed to the
 * scene's space if your top level transforms the scene. */
void cbvhIntersectCandidate(rayQueryEXT query, uvec2 scene, CbvhRay ray, inout CbvhNearestHit found) {
  if (rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionNoneEXT)
    found.hit.t = min(found.hit.t, rayQueryGetIntersectionTEXT(query, true));
  uint customIndex = uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, false)),
       box = uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, false));
  if (cbvhIntersectBox(scene, customIndex, box, ray, false, found)) rayQueryGenerateIntersectionEXT(query, found.hit.t);
}

/* Traces a ray through the library's top level. A power of two scales the direction's largest component into [1,4),
 * because drivers may not support extreme lengths. If that component is not a normal float, the ray misses. */
bool cbvhQuery(uvec2 address, CbvhRay ray, const bool anyHit, inout CbvhHit hit) {
  CbvhNearestHit found = cbvhNoHit(ray);
  hit = found.hit;
  vec3 size = abs(ray.direction);
  uint exponent = floatBitsToUint(max(size.x, max(size.y, size.z))) >> 23;
  if (!cbvhMayHit(ray) || exponent == 0u) return false;
  vec3 direction = ray.direction * uintBitsToFloat(max(254u - exponent, 1u) << 23);
  float unit = uintBitsToFloat(min(exponent, 253u) << 23);
  float tmin = max(ray.tnear, 0.0) * unit, tmax = min(ray.tfar, 3.40282347e38) * unit;
  tmax = min(tmax, 3.40282347e38);
  if (tmin > tmax) return false; // undefined in Vulkan
  rayQueryEXT query;
  rayQueryInitializeEXT(query, accelerationStructureEXT(CbvhSceneAt(address).scene.topLevel),
                        anyHit ? gl_RayFlagsTerminateOnFirstHitEXT : gl_RayFlagsNoneEXT, 0xFFu, ray.origin, tmin,
                        direction, tmax);
  bool isHit = false;
  while (rayQueryProceedEXT(query)) {
    uint customIndex = uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, false)),
         box = uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, false));
    if (!cbvhIntersectBox(address, customIndex, box, ray, anyHit, found)) continue;
    isHit = true;
    rayQueryGenerateIntersectionEXT(query, clamp(found.hit.t * unit, tmin, tmax));
    if (anyHit) rayQueryTerminateEXT(query);
  }
  hit = cbvhGetHit(found);
  return isHit;
}

/* cbvhIntersect and cbvhOccluded by ray queries. The scene must have been created with
 * RTC_VULKAN_TRAVERSAL_RAY_QUERY. */
bool cbvhQueryIntersect(uvec2 scene, CbvhRay ray, out CbvhHit hit) { return cbvhQuery(scene, ray, false, hit); }

bool cbvhQueryOccluded(uvec2 scene, CbvhRay ray) {
  CbvhHit hit;
  return cbvhQuery(scene, ray, true, hit);
}

#endif
