// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Traces rays in a shader. Installed as embree3/cbvh.glsl. A scene is the address from rtcGetVulkanSceneAddress, as two
 * words, the lower word first; nothing is bound. The device needs bufferDeviceAddress and scalarBlockLayout. With
 * CBVH_FLOAT64, cVERT's distances are the same as on the CPU.
 *
 *   #define CBVH_LEAF_KINDS ...   optional: (specialization) constant with all bits of rtcGetVulkanSceneLeafKinds;
 *                                 no other kinds are compiled. Default: all kinds. If a kind of the scene is
 *                                 missing, the behavior is undefined
 *   #define CBVH_STACK_SIZE ...   stackSize of rtcGetVulkanSceneStatistics or more. Default: 96. With a smaller stack
 *                                 than the scene needs, the behavior is undefined
 *   #define CBVH_FLOAT64          optional: if shaderFloat64 is enabled on the device
 *   #define CBVH_RAY_QUERY        optional: ray queries, see below. Requires GL_EXT_ray_query
 *   #include <embree3/cbvh.glsl>
 *
 *   CbvhRay ray = CbvhRay(origin, tnear, direction, tfar, mask, time);
 *   CbvhHit hit;
 *   if (cbvhIntersect(scene, ray, hit)) ...
 *   if (cbvhOccluded(scene, ray)) ...
 *
 * The members of a CbvhRay have these names and this order. cbvhMakeRay(origin, tnear, direction, tfar) returns a ray
 * with all bits of the mask, at time 0. A CbvhHit has the distance t and the members of RTCHit: u, v, Ng, primID,
 * geomID and instID. tnear, tfar and t are in lengths of the direction. After a miss, t is tfar and the IDs are
 * CBVH_INVALID_ID.
 *
 * The API consists of the functions, types, constants and macros that this comment names. CbvhNearestHit has no public
 * members. Other names may change in any version.
 *
 * Each call inlines the traversal. A loop around one call compiles faster than several calls.
 *
 * Scenes created with RTC_VULKAN_TRAVERSAL_RAY_QUERY can be traced through the driver's acceleration structures, either
 * with the library's top level:
 *
 *   if (cbvhQueryIntersect(scene, ray, hit)) ...
 *   if (cbvhQueryOccluded(scene, ray)) ...
 *
 * or with your own top level, which contains your triangles and the instances from rtcGetVulkanSceneInstances:
 *
 *   CbvhNearestHit found = cbvhNoHit(ray);
 *   rayQueryEXT query;
 *   rayQueryInitializeEXT(query, topLevel, gl_RayFlagsNoneEXT, 0xFFu, ray.origin, ray.tnear, ray.direction, ray.tfar);
 *   while (rayQueryProceedEXT(query))
 *     if (rayQueryGetIntersectionTypeEXT(query, false) == gl_RayQueryCandidateIntersectionAABBEXT)
 *       cbvhIntersectCandidate(query, scene, ray, found);
 *     else rayQueryConfirmIntersectionEXT(query);
 *   if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionGeneratedEXT)
 *     hit = cbvhGetHit(found);
 *
 * An intersection shader calls cbvhIntersectBox(scene, customIndex, box, ray, anyHit, found) instead, with the custom
 * index of the instance, the index of the box (gl_PrimitiveID), and a compile-time constant: true if any hit suffices.
 * If it returns true, cbvhGetHit(found) returns the hit.
 */

#ifndef CBVH_GLSL
#define CBVH_GLSL

#include "framed_block.glsl"
#include "instance.glsl"
#include "mesh_block.glsl"
#include "meshes.glsl"
#include "tile.glsl"
#include "vert_block.glsl"

#ifndef CBVH_LEAF_KINDS
#define CBVH_LEAF_KINDS 0xFFFFFFFFu
#endif

#ifndef CBVH_STACK_SIZE
#define CBVH_STACK_SIZE 96
#endif

bool cbvhHasKind(uint type) { return (uint(CBVH_LEAF_KINDS) & (1u << type)) != 0u; }

bool cbvhIsNode(uint type) {
  return type == nodeReferenceType || (cbvhHasKind(movingNodeReferenceType) && type == movingNodeReferenceType);
}

/* True if all framed blocks of the scene have this kind. The compiler then removes the code of other kinds. */
bool cbvhHasOnly(uint kind) {
  return (uint(CBVH_LEAF_KINDS) & (framedKinds << firstBlockReferenceType)) == (1u << blockReferenceType(kind));
}

/* isPresent: receives true for each child that exists at the time. */
CbvhNode cbvhNodeAt(CbvhMovingNode node, float time, out bvec4 isPresent) {
  CbvhNode now = node.atZero;
  for (int k = 0; k < 3; k++) {
    now.lower[k] += time * node.lowerDifference[k];
    now.upper[k] += time * node.upperDifference[k];
  }
  isPresent = bvec4(uvec4(lessThanEqual(node.begin, vec4(time))) * uvec4(lessThan(vec4(time), node.end)));
  return now;
}

/* Factors of distances at which a ray enters and leaves boxes, so that rounding culls no box with a hit. Compare with
 * kernels/cbvh/traversal/top_level_ray.h. In half ulps: 4 for the rule's shear and sheared vertices, 1 for the
 * product, and 5 for the reciprocal, because Vulkan's quotients are off by up to 2.5 ulps. On the direction's largest
 * axis: 1 for the product, and 10 for the quotients of the shear and of the box test, which may differ. The larger
 * sum is 11, and 6 ulps are 12. */
const float cbvhNearFactor = 1.0 - 6.0 * floatUlp, cbvhFarFactor = 1.0 + 6.0 * floatUlp;

/* Bits of a key with the entry distance. Without the sign, because max(0,-0) may be -0. */
const uint cbvhEntryBits = 0x7FFFFFFCu;

/* Returns sorted keys of the children, nearest first: the bits of a lower bound of the distance, which compare as
 * integers, with 3 minus the child's index in the lower two bits; 0xFFFFFFFF for missed children. Of children at the
 * same distance, later ones come first, as in Embree. */
uvec4 cbvhSortChildren(CbvhNode node, bvec4 isPresent, CbvhPreparedRay ray, float tfar) {
  vec4 enter = vec4(ray.tnear), leave = vec4(tfar);
  for (int k = 0; k < 3; k++) {
    vec4 a = (node.lower[k] - ray.org[k]) * ray.rcp[k], b = (node.upper[k] - ray.org[k]) * ray.rcp[k];
    enter = max(enter, min(a, b));
    leave = min(leave, max(a, b));
  }
  enter *= cbvhNearFactor;
  bvec4 isHit = lessThanEqual(enter, leave * cbvhFarFactor);
  uvec4 keys = mix(uvec4(0xFFFFFFFFu), (floatBitsToUint(enter) & cbvhEntryBits) | uvec4(3u, 2u, 1u, 0u), isHit);
  keys = mix(uvec4(0xFFFFFFFFu), keys, isPresent);
  keys = uvec4(min(keys.xz, keys.yw), max(keys.xz, keys.yw)); // x,y: lesser of each pair; z,w: greater
  keys = uvec4(min(keys.x, keys.y), max(keys.x, keys.y), min(keys.z, keys.w), max(keys.z, keys.w));
  return uvec4(keys.x, min(keys.y, keys.z), max(keys.y, keys.z), keys.w);
}

uint cbvhChildOfKey(uint key) { return 3u - (key & 3u); }
float cbvhEntryOfKey(uint key) { return uintBitsToFloat(key & cbvhEntryBits); }

/* Intersects a leaf that is not an instance. framed: see cbvhReport. */
bool cbvhTraceLeaf(SceneData scene, CbvhPreparedRay ray, uint reference, const bool anyHit, inout CbvhHit hit,
                   inout vec2 framed, inout CbvhVertNearest nearest) {
  uint type = referenceType(reference), index = referenceIndex(reference);
  if (cbvhHasKind(gridLeafReferenceType) && type == gridLeafReferenceType)
    return cbvhTraceGridLeaf(scene, ray, index, anyHit, hit);
  if (cbvhHasKind(firstRunReferenceType) && isRunType(type))
    return cbvhTraceRun(scene, ray, index, runLength(type), anyHit, hit);
  if (cbvhHasKind(blockReferenceType(kindTile)) && type == blockReferenceType(kindTile))
    return cbvhTraceTile(scene, cbvhPointer(scene, index), ray, anyHit, hit, nearest);
  if (cbvhHasKind(blockReferenceType(kindVert)) && type == blockReferenceType(kindVert))
    return cbvhTraceVert(scene, cbvhPointer(scene, index), ray, anyHit, hit, nearest);
  if (cbvhHasKind(movingBlockReferenceType) && type == movingBlockReferenceType)
    return cbvhTraceMovingVert(scene, cbvhPointer(scene, index), ray, anyHit, hit, nearest);
  if (cbvhHasKind(meshBlockReferenceType) && type == meshBlockReferenceType)
    return cbvhTraceMesh(scene, cbvhPointer(scene, index), ray, anyHit, hit, nearest);
  if ((uint(CBVH_LEAF_KINDS) & (framedKinds << firstBlockReferenceType)) == 0u) return false;
  uint kind = cbvhHasOnly(kindLeaf)    ? kindLeaf
              : cbvhHasOnly(kindVoxel) ? kindVoxel
              : cbvhHasOnly(kindGrid)  ? kindGrid
                                       : type - firstBlockReferenceType;
  return cbvhTraceFramed(scene, cbvhPointer(scene, index), kind, ray, anyHit, hit, framed);
}

/* address: of the SceneData. */
bool cbvhTrace(uvec2 address, CbvhRay worldRay, const bool anyHit, inout CbvhHit hit) {
  hit.t = worldRay.tfar;
  hit.u = hit.v = 0.0;
  hit.Ng = vec3(0.0);
  hit.primID = hit.geomID = hit.instID = CBVH_INVALID_ID;
  if (!cbvhMayHit(worldRay)) return false;

  SceneData scene = CbvhSceneAt(address).scene;
  CbvhNodes nodes = CbvhNodes(scene.nodes);
  CbvhPreparedRay ray = cbvhPreparedRay(worldRay);
  bool found = false;
  vec2 framed = vec2(-1.0);
  CbvhVertNearest nearest = cbvhNoVertNearest();

  uvec2 stack[CBVH_STACK_SIZE];  // pairs of reference and key of cbvhSortChildren
  int top = 0, instanceTop = -1; // instanceTop: `top` when the ray entered an instance
  uint current = scene.root;

  while (true) {
    while (current != emptyReference && cbvhIsNode(referenceType(current))) {
      bvec4 isPresent = bvec4(true);
      CbvhNode node;
      if (cbvhHasKind(movingNodeReferenceType) && referenceType(current) == movingNodeReferenceType)
        node = cbvhNodeAt(CbvhMovingNodes(scene.movingNodes).at[referenceIndex(current)], ray.time, isPresent);
      else node = nodes.at[current];
      uvec4 keys = cbvhSortChildren(node, isPresent, ray, hit.t);
      current = emptyReference;
      if (keys.w != 0xFFFFFFFFu) stack[top++] = uvec2(node.children[cbvhChildOfKey(keys.w)], keys.w);
      if (keys.z != 0xFFFFFFFFu) stack[top++] = uvec2(node.children[cbvhChildOfKey(keys.z)], keys.z);
      if (keys.y != 0xFFFFFFFFu) stack[top++] = uvec2(node.children[cbvhChildOfKey(keys.y)], keys.y);
      if (keys.x != 0xFFFFFFFFu) {
        current = node.children[cbvhChildOfKey(keys.x)];
        ray.entryT = cbvhEntryOfKey(keys.x);
      }
    }

    if (current != emptyReference) {
      if (cbvhHasKind(instanceReferenceType) && referenceType(current) == instanceReferenceType) {
        uint geomID = referenceIndex(current);
        GeometryData instance = CbvhGeometries(scene.geometries).at[geomID];
        CbvhTransform toLocal;
        if ((instance.mask & worldRay.mask) != 0u && cbvhWorldToLocal(instance, ray.time, toLocal)) {
          CbvhRay local = cbvhTransformed(toLocal, worldRay);
          if (cbvhMayHit(local)) {
            ray = cbvhPreparedRay(local);
            ray.instID = geomID;
            ray.firstGeometry = instance.firstGeometry;
            instanceTop = top;
            current = instance.root;
            continue;
          }
        }
      } else if (cbvhTraceLeaf(scene, ray, current, anyHit, hit, framed, nearest)) {
        found = true;
        if (anyHit) return true;
      }
    }

    do {
      if (cbvhHasKind(instanceReferenceType) && top == instanceTop) {
        ray = cbvhPreparedRay(worldRay);
        instanceTop = -1;
      }
      if (top == 0) {
        if (hit.t == framed.x) hit.t = framed.y;
        return found;
      }
      top--;
    } while (stack[top].y > (floatBitsToUint(hit.t) | 3u));
    current = stack[top].x;
    ray.entryT = cbvhEntryOfKey(stack[top].y);
  }
  return found;
}

/* Finds the closest hit. If there is none, returns false and sets hit.t to ray.tfar and all IDs to CBVH_INVALID_ID. */
bool cbvhIntersect(uvec2 scene, CbvhRay ray, out CbvhHit hit) { return cbvhTrace(scene, ray, false, hit); }

/* True if the ray hits anything. */
bool cbvhOccluded(uvec2 scene, CbvhRay ray) {
  CbvhHit hit;
  return cbvhTrace(scene, ray, true, hit);
}

#ifdef CBVH_RAY_QUERY
#include "ray_query.glsl"
#endif

#endif
