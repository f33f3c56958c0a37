// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Intersects a ray with the leaves of a cLEAF block, from their bytes to a hit. It calls every function of a GLSL
 * intersector except for the traversal, so that the compiler checks all of them. Leaves are visited in Morton order, so
 * the result is not meaningful. The shader is compiled but not run. */

#version 460
#include "cbvh/paper/leaf/crossing.h"
#include "cbvh/paper/normal.h"
#include "cbvh/paper/tree.h"

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Blocks { uint words[]; };
layout(std430, binding = 1) readonly buffer Rays { vec4 rays[]; };  // origin and tnear, direction and tfar
layout(std430, binding = 2) writeonly buffer Hits { vec4 hits[]; }; // normal and t, parameters and leaf

const uint block = 0u; // index of its first word

BlockHeader readHeader() {
  BlockHeader header;
  for (int i = 0; i < 3; i++) {
    header.center[i] = uintBitsToFloat(words[block + i]);
    for (int k = 0; k < 4; k++) header.columns[i][k] = uintBitsToFloat(words[block + 4 + 4 * i + k]);
  }
  header.surface = words[block + 3];
  header.primID = words[block + 16];
  header.info = words[block + 17];
  header.tiling = words[block + 18];
  return header;
}

uint readWord(uint level, uint m) { return words[block + blockHeaderBytes / 4u + nodesOfLevels(level) + m]; }

Heights readHeights(BlockLayout sizes, uint m) {
  uint first = block + sizes.leafOffset / 4u + 2u * m;
  return Heights(words[first], words[first + 1u]);
}

/* Decodes the box of a group along the path to it. */
NodeBox groupBox(BlockLayout sizes, uint m) {
  NodeBox box = rootBox();
  for (uint level = 0u; level + 1u < sizes.nodeLevels; level++) {
    uint shift = 2u * (sizes.nodeLevels - 1u - level);
    box = childBox(false, readWord(level, m >> shift), Heights(0u, 0u), int((m >> (shift - 2u)) & 3u), box);
  }
  return box;
}

void main() {
  uint ray = gl_GlobalInvocationID.x;
  vec4 origin = rays[2u * ray], direction = rays[2u * ray + 1u];
  WorldRay world;
  world.org = float[3](origin.x, origin.y, origin.z);
  world.dir = float[3](direction.x, direction.y, direction.z);
  world.tnear = origin.w;
  world.tfar = direction.w;

  BlockHeader header = readHeader();
  BlockLayout sizes = blockLayout(kindOf(header.info), heightOf(header.info));
  Segment segment = enterBlock(header, world, 1.0);
  hits[2u * ray] = vec4(0.0);
  if (!segment.valid || !hasGroups(kindOf(header.info))) return;

  WalkState state = startOfWalk();
  uint groups = sizes.leavesPerSide * sizes.leavesPerSide / 4u;
  for (uint leaf = 0u; leaf < 4u * groups; leaf++) {
    uint m = leaf / 4u;
    NodeBox parent = groupBox(sizes, m);
    LeafPatch patch_ = decodeLeaf(readWord(sizes.nodeLevels - 1u, m), readHeights(sizes, m), int(leaf & 3u), parent);
    if (!isOnSegment(rangeInBox(segment, patch_.box, 3))) {
      if (needsPassedBoxes(state) && isOnSegment(rangeInBox(segment, patch_.box, 2)))
        state = passBox(state, segment.P0[2] > upperOf(patch_.box, 2)).next;
      continue;
    }
    Crossing x = crossPatch(segment, patch_);
    HitResult result = crossLeaf(state, x.event);
    state = result.next;
    if (result.hit == hitNone) continue;
    float s = result.hit == hitRoot ? x.s0 + parabolaRoot(x.f) * (x.s1 - x.s0) : x.s0;
    if (result.hit == hitLip) {
      Lip lip = Lip(borderWidthOf(header.info), 0.5 * patch_.thickness, segment.epsilon[2]);
      LipIntersection at = intersectLipsOfLeaf(x, mortonX(leaf), mortonY(leaf), sizes.leavesPerSide - 1u, lip);
      if (!at.hit) continue;
      s = x.s0 + at.k * (x.s1 - x.s0);
    }
    state = afterHit(state);

    float u = positionInBox(segment, patch_.box, 0, s), v_ = positionInBox(segment, patch_.box, 1, s);
    Vector p;
    for (int k = 0; k < 3; k++) p.x[k] = segmentAt(segment, k, s);
    Vector n = worldNormal(header, p, patchSlope(patch_, 0, v_), patchSlope(patch_, 1, u));
    vec3 normal = vec3(n.x[0], n.x[1], n.x[2]);
    float along = dot(normal, direction.xyz), direction2 = dot(direction.xyz, direction.xyz);
    if (isMirrored(along, dot(normal, normal), direction2, result.from))
      normal -= 2.0 * along / direction2 * direction.xyz;
    float size = float(1u << heightOf(header.info)) / float(sizes.leavesPerSide); // size of a leaf in quads
    float faceU = faceParameter(cornerUOf(header.tiling), blockXOf(header.info), lastXOf(header.tiling),
                                heightOf(header.info), size * (float(mortonX(leaf)) + u));
    float faceV = faceParameter(cornerVOf(header.tiling), blockYOf(header.info), lastYOf(header.tiling),
                                heightOf(header.info), size * (float(mortonY(leaf)) + v_));
    hits[2u * ray] = vec4(normal, worldT(segment, s));
    hits[2u * ray + 1u] = vec4(faceU, faceV, uintBitsToFloat(leaf), 0.0);
  }
}
