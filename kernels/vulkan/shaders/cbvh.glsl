// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Tracing rays in a shader, installed as embree3/cbvh.glsl. A scene is the address that rtcGetVulkanSceneAddress returns, as two
 * words; nothing has to be bound. Of the device's features the shader needs bufferDeviceAddress,
 * scalarBlockLayout. With shaderFloat64 distances of cVERT are those of the processor.
 *
 *   #define CBVH_KINDS ...        optional: kinds of leaves that scenes have, from rtcGetVulkanSceneKinds;
 *                                 a constant or a specialization constant. What is not named is not compiled.
 *   #define CBVH_STACK ...        optional: entries of a ray's stack, as many as stackSize of
 *                                 rtcGetVulkanSceneStatistics says
 *   #define CBVH_FLOAT64          where shaderFloat64 is there
 *   #define CBVH_RAY_QUERY        optional: ray queries, below
 *   #include <embree3/cbvh.glsl>
 *
 *   CbvhRay ray = CbvhRay(origin, tnear, direction, tfar, 0xFFFFFFFFu, time); // before the time is the mask
 *   CbvhHit hit;
 *   if (cbvhIntersect(scene, ray, hit)) ...
 *   if (cbvhOccluded(scene, ray)) ...
 *
 * The traversal is compiled into each place that calls it: a loop around one call compiles sooner than
 * several calls.
 *
 * Where the driver has ray queries, its own structures may take the place of the tree above blocks: of scenes that were made
 * with RTC_VULKAN_TRAVERSAL_RAY_QUERY. By the library's top level:
 *
 *   if (cbvhQueryIntersect(scene, ray, hit)) ...
 *   if (cbvhQueryOccluded(scene, ray)) ...
 *
 * or by a top level of your own, beside your own triangles, that has the instances of rtcGetVulkanSceneInstances:
 *
 *   CbvhCandidates found = cbvhNoCandidates(ray);
 *   rayQueryEXT query;
 *   rayQueryInitializeEXT(query, topLevel, gl_RayFlagsNoneEXT, 0xFFu, ray.origin, ray.tnear, ray.direction, ray.tfar);
 *   while (rayQueryProceedEXT(query))
 *     if (rayQueryGetIntersectionTypeEXT(query, false) == gl_RayQueryCandidateIntersectionAABBEXT)
 *       cbvhIntersectCandidate(query, scene, ray, found);
 *     else rayQueryConfirmIntersectionEXT(query);
 *   if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionGeneratedEXT) hit = cbvhHitOf(found);
 */

#ifndef CBVH_GLSL
#define CBVH_GLSL

#include "framed_block.glsl"
#include "instance.glsl"
#include "mesh_block.glsl"
#include "meshes.glsl"
#include "vert_block.glsl"

#ifndef CBVH_KINDS
#define CBVH_KINDS 0xFFFFFFFFu
#endif

#ifndef CBVH_STACK
#define CBVH_STACK 96
#endif

bool cbvhHasKind (uint type) { return (uint(CBVH_KINDS) & (1u << type)) != 0u; }

bool cbvhIsNode (uint type) { return type == nodeReference || (cbvhHasKind(movingNodeReference) && type == movingNodeReference); }

/* whether a scene has blocks of a kind and of no other with a frame */
bool cbvhHasOnly (uint kind)
{
  return (uint(CBVH_KINDS) & (framedKinds << firstBlockReference)) == (1u << blockReference(kind));
}

/* A node at a time. isThere: children that are, at that time */
CbvhNode cbvhNodeAt (CbvhMovingNode node, float time, out bvec4 isThere)
{
  CbvhNode now = node.atZero;
  for (int k = 0; k < 3; k++) {
    now.lower[k] += time*node.lowerDifference[k];
    now.upper[k] += time*node.upperDifference[k];
  }
  isThere = bvec4(uvec4(lessThanEqual(node.begin, vec4(time)))*uvec4(lessThan(vec4(time), node.end)));
  return now;
}

/* Relative error of a distance to a plane: half an ulp each of the difference and the product, and 2.5 of the
 * reciprocal, as Vulkan allows for quotients. Embree's robust traversal has 3 ulps, as its quotients are exact. */
const float cbvhNodeSlack = 4.0*floatUlp;

/* Children that the ray meets, nearest first: keys whose upper bits are the distance, and whose lower two say
 * the child, cbvhChildOfKey; those that it does not meet come last. Of two as near Embree takes the later one. */
uvec4 cbvhSortChildren (CbvhNode node, bvec4 isThere, CbvhTravel ray, float tfar)
{
  vec4 enter = vec4(ray.tnear), leave = vec4(tfar);
  for (int k = 0; k < 3; k++) {
    vec4 a = (node.lower[k] - ray.org[k])*ray.rcp[k], b = (node.upper[k] - ray.org[k])*ray.rcp[k];
    enter = max(enter, min(a, b));
    leave = min(leave, max(a, b));
  }
  bvec4 isMet = lessThanEqual(enter*(1.0 - cbvhNodeSlack), leave*(1.0 + cbvhNodeSlack));
  uvec4 keys = mix(uvec4(0xFFFFFFFFu), (floatBitsToUint(enter) & ~uvec4(3u)) | uvec4(3u, 2u, 1u, 0u), isMet);
  keys = mix(uvec4(0xFFFFFFFFu), keys, isThere);
  keys = uvec4(min(keys.xz, keys.yw), max(keys.xz, keys.yw)); // x,y: lesser of each pair; z,w: greater
  keys = uvec4(min(keys.x, keys.y), max(keys.x, keys.y), min(keys.z, keys.w), max(keys.z, keys.w));
  return uvec4(keys.x, min(keys.y, keys.z), max(keys.y, keys.z), keys.w);
}

uint cbvhChildOfKey (uint key) { return 3u - (key & 3u); }
float cbvhEntryOfKey (uint key) { return uintBitsToFloat(key & ~3u); }

/* A leaf of the tree that is no instance; true if something nearer is hit. framed: see cbvhReport; nearest: of cVERT */
bool cbvhTraceLeaf (SceneData scene, CbvhTravel ray, uint reference, const bool anyHit, inout CbvhHit hit, inout vec2 framed, inout CbvhVertNearest nearest)
{
  uint type = referenceType(reference), index = referenceIndex(reference);
  if (cbvhHasKind(cellReference) && type == cellReference) return cbvhTraceCell(scene, ray, index, anyHit, hit);
  if (cbvhHasKind(triangleReference) && isRunType(type)) return cbvhTraceRun(scene, ray, index, countOfRun(type), anyHit, hit);
  if (cbvhHasKind(blockReference(kindVert)) && type == blockReference(kindVert))
    return cbvhTraceVert(scene, cbvhPointer(scene, index), ray, anyHit, hit, nearest);
  if (cbvhHasKind(movingBlockReference) && type == movingBlockReference)
    return cbvhTraceMovingVert(scene, cbvhPointer(scene, index), ray, anyHit, hit, nearest);
  if (cbvhHasKind(meshBlockReference) && type == meshBlockReference)
    return cbvhTraceMesh(scene, cbvhPointer(scene, index), ray, anyHit, hit, nearest);
  if ((uint(CBVH_KINDS) & (framedKinds << firstBlockReference)) == 0u) return false;
  uint kind = cbvhHasOnly(kindLeaf) ? kindLeaf : cbvhHasOnly(kindVoxel) ? kindVoxel : cbvhHasOnly(kindGrid) ? kindGrid : type - firstBlockReference;
  return cbvhTraceFramed(scene, cbvhPointer(scene, index), kind, ray, anyHit, hit, framed);
}

bool cbvhTrace (uvec2 address, CbvhRay worldRay, const bool anyHit, inout CbvhHit hit)
{
  hit.t = worldRay.tfar;
  hit.u = hit.v = 0.0;
  hit.Ng = vec3(0.0);
  hit.primID = hit.geomID = hit.instID = CBVH_NONE;
  if (!cbvhMayHit(worldRay)) return false;

  SceneData scene = CbvhSceneAt(address).scene;
  CbvhNodes nodes = CbvhNodes(scene.nodes);
  CbvhTravel ray = cbvhTravel(worldRay);
  bool found = false;
  vec2 framed = vec2(-1.0);
  CbvhVertNearest nearest = cbvhNoVertNearest();

  uvec2 stack[CBVH_STACK];       // references, and where the ray enters their boxes
  int top = 0, instanceTop = -1; // the stack's height where an instance was entered
  uint current = scene.root;

  while (true)
  {
    /* down to a leaf */
    while (current != emptyReference && cbvhIsNode(referenceType(current)))
    {
      bvec4 isThere = bvec4(true);
      CbvhNode node;
      if (cbvhHasKind(movingNodeReference) && referenceType(current) == movingNodeReference)
        node = cbvhNodeAt(CbvhMovingNodes(scene.movingNodes).at[referenceIndex(current)], ray.time, isThere);
      else node = nodes.at[current];
      uvec4 keys = cbvhSortChildren(node, isThere, ray, hit.t);
      current = emptyReference;
      if (keys.w != 0xFFFFFFFFu) stack[top++] = uvec2(node.children[cbvhChildOfKey(keys.w)], keys.w);
      if (keys.z != 0xFFFFFFFFu) stack[top++] = uvec2(node.children[cbvhChildOfKey(keys.z)], keys.z);
      if (keys.y != 0xFFFFFFFFu) stack[top++] = uvec2(node.children[cbvhChildOfKey(keys.y)], keys.y);
      if (keys.x != 0xFFFFFFFFu) {
        current = node.children[cbvhChildOfKey(keys.x)];
        ray.enter = cbvhEntryOfKey(keys.x);
      }
    }

    if (current != emptyReference)
    {
      if (cbvhHasKind(instanceReference) && referenceType(current) == instanceReference)
      {
        uint geomID = referenceIndex(current);
        GeometryData instance = CbvhGeometries(scene.geometries).at[geomID];
        CbvhTransform toLocal;
        if ((instance.mask & worldRay.mask) != 0u && cbvhWorldToLocal(instance, ray.time, toLocal))
        {
          CbvhRay local = cbvhTransformed(toLocal, worldRay);
          if (cbvhMayHit(local)) {
            ray = cbvhTravel(local);
            ray.instID = geomID;
            ray.firstGeometry = instance.firstGeometry;
            instanceTop = top;
            current = instance.root;
            continue;
          }
        }
      }
      else if (cbvhTraceLeaf(scene, ray, current, anyHit, hit, framed, nearest)) {
        found = true;
        if (anyHit) return true;
      }
    }

    /* back to what waits and is not behind a hit */
    do {
      if (cbvhHasKind(instanceReference) && top == instanceTop) { ray = cbvhTravel(worldRay); instanceTop = -1; }
      if (top == 0) {
        if (hit.t == framed.x) hit.t = framed.y;
        return found;
      }
      top--;
    } while (stack[top].y > (floatBitsToUint(hit.t) | 3u));
    current = stack[top].x;
    ray.enter = cbvhEntryOfKey(stack[top].y);
  }
  return found;
}

/* Closest hit. False if there is none; hit.t is then the ray's tfar, and its IDs are CBVH_NONE. */
bool cbvhIntersect (uvec2 scene, CbvhRay ray, out CbvhHit hit) { return cbvhTrace(scene, ray, false, hit); }

/* Whether the ray hits anything. */
bool cbvhOccluded (uvec2 scene, CbvhRay ray)
{
  CbvhHit hit;
  return cbvhTrace(scene, ray, true, hit);
}

#ifdef CBVH_RAY_QUERY
#include "ray_query.glsl"
#endif

#endif
