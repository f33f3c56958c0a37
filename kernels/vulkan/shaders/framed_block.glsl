// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Intersects a ray with a block of cGRID, cVOXEL or cLEAF (kernels/cbvh/paper), whose boxes are in a local frame.
 *
 * Traversal keeps two masks of 4 bits per level: pending children, and those that the ray passes over or under. Going
 * up, it decodes boxes again along the path from the root, which is faster than a stack of boxes.
 *
 * Children are visited along the ray. Mirrored so that x and y ascend, the order is 0, then 1 and 2 by entry, then 3.
 * Bit i of a mask is child i ^ flip. */

#ifndef CBVH_FRAMED_BLOCK_GLSL
#define CBVH_FRAMED_BLOCK_GLSL

#include "triangle.glsl"
#include "../../cbvh/paper/tree.h"
#include "../../cbvh/paper/leaf/crossing.h"
#include "../../cbvh/paper/normal.h"

/* The ray in the block's frame, in which it is a straight segment. */
struct CbvhLocalRay {
  Segment segment;
  vec3 lower, upper; // start minus and plus epsilon
  vec3 rcp;
  uint flip;   // bit k: the direction descends along axis k (x, y)
  float scale; // 1/largest component of the direction; factor from the segment's distances to the ray's
};

/* Parameters at which the segment enters and leaves the boxes of a node's children. */
struct CbvhSlabs {
  vec4 enter, leave;     // children 0 to 3
  vec4 enterXY, leaveXY; // between their x and y planes only
  vec4 leaveZ;
};

/* Parameters at which a ray enters and leaves the space between two planes. */
vec2 cbvhSlab(CbvhLocalRay ray, int axis, float lower, float upper) {
  float a = (lower - ray.upper[axis]) * ray.rcp[axis], b = (upper - ray.lower[axis]) * ray.rcp[axis];
  return vec2(min(a, b), max(a, b));
}

/* x0, x1, y0, y1: slabs of the columns and rows of children. */
CbvhSlabs cbvhJoin(vec2 x0, vec2 x1, vec2 y0, vec2 y1, vec4 enterZ, vec4 leaveZ) {
  CbvhSlabs slabs;
  slabs.enterXY = max(vec4(x0.x, x1.x, x0.x, x1.x), vec4(y0.x, y0.x, y1.x, y1.x));
  slabs.leaveXY = min(vec4(x0.y, x1.y, x0.y, x1.y), vec4(y0.y, y0.y, y1.y, y1.y));
  slabs.enter = max(slabs.enterXY, enterZ);
  slabs.leave = min(slabs.leaveXY, leaveZ);
  slabs.leaveZ = leaveZ;
  return slabs;
}

CbvhSlabs cbvhNodeSlabs(CbvhLocalRay ray, uint word, NodeBox box) {
  vec2 xy[4];
  for (int axis = 0; axis < 2; axis++)
    for (int column = 0; column < 2; column++) {
      float lower = box.lower[axis] + lowerPlane((word >> lowerShift(axis)) & planePairMask, column) * box.extent[axis];
      float upper = box.lower[axis] + upperPlane((word >> upperShift(axis)) & planePairMask, column) * box.extent[axis];
      xy[2 * axis + column] = cbvhSlab(ray, axis, lower, upper);
    }
  vec4 enterZ, leaveZ;
  for (int c = 0; c < 4; c++) {
    Interval z = zInterval(zCode(word, c));
    vec2 p = cbvhSlab(ray, 2, box.lower[2] + z.lower * box.extent[2], box.lower[2] + z.upper * box.extent[2]);
    enterZ[c] = p.x;
    leaveZ[c] = p.y;
  }
  return cbvhJoin(xy[0], xy[1], xy[2], xy[3], enterZ, leaveZ);
}

CbvhSlabs cbvhGroupSlabs(CbvhLocalRay ray, uint word, Heights heights, NodeBox box) {
  if (hasSeparateLeaves(heights)) return cbvhNodeSlabs(ray, word, box);
  vec2 xy[4];
  for (int axis = 0; axis < 2; axis++) {
    float p0 = latticePlane(word, axis, 0, box), p1 = latticePlane(word, axis, 1, box),
          p2 = latticePlane(word, axis, 2, box);
    xy[2 * axis] = cbvhSlab(ray, axis, p0, p1);
    xy[2 * axis + 1] = cbvhSlab(ray, axis, p1, p2);
  }
  vec4 enterZ, leaveZ;
  for (int c = 0; c < 4; c++) {
    NodeBox leaf = decodeLatticeLeaf(word, heights, c, box).box;
    vec2 p = cbvhSlab(ray, 2, leaf.lower[2], upperOf(leaf, 2));
    enterZ[c] = p.x;
    leaveZ[c] = p.y;
  }
  return cbvhJoin(xy[0], xy[1], xy[2], xy[3], enterZ, leaveZ);
}

/* Bit i of the result is component i. */
uint cbvhMask(bvec4 b) { return (b.x ? 1u : 0u) | (b.y ? 2u : 0u) | (b.z ? 4u : 0u) | (b.w ? 8u : 0u); }

/* Converts a mask of children to the order of visits: moves bit i to bit i ^ flip. */
uint cbvhToOrder(uint mask, uint flip) {
  if ((flip & 1u) != 0u) mask = ((mask & 5u) << 1) | ((mask >> 1) & 5u);
  if ((flip & 2u) != 0u) mask = ((mask & 3u) << 2) | (mask >> 2);
  return mask;
}

BlockHeader cbvhReadHeader(CbvhPointer block) {
  BlockHeader header;
  vec4 q0 = uintBitsToFloat(cbvhQuadword(block, 0u));
  for (int i = 0; i < 3; i++) {
    vec4 column = uintBitsToFloat(cbvhQuadword(block, 1u + uint(i)));
    header.center[i] = q0[i];
    for (int k = 0; k < 4; k++) header.columns[i][k] = column[k];
  }
  header.surface = floatBitsToUint(q0.w);
  header.primID = cbvhWord(block, 16u);
  header.info = cbvhWord(block, 17u);
  header.tiling = cbvhWord(block, 18u);
  return header;
}

const uint CBVH_FIRST_NODE = blockHeaderBytes / 4u; // offset of the root in words

/* Node m of a level, in Morton order. */
uint cbvhNodeWord(CbvhPointer block, uint level, uint m) {
  return cbvhWord(block, CBVH_FIRST_NODE + nodesOfLevels(level) + m);
}

/* Decodes boxes from the root to node m of a level. */
NodeBox cbvhBoxOfNode(CbvhPointer block, uint level, uint m) {
  NodeBox box = rootBox();
  for (uint above = 0u; above < level; above++) {
    uint shift = 2u * (level - above);
    box = decodeChild(cbvhNodeWord(block, above, m >> shift), int((m >> (shift - 2u)) & 3u), box);
  }
  return box;
}

struct CbvhLeafHit {
  float s;    // parameter of the segment
  uint leaf;  // index of the leaf, in Morton order
  float u, v; // position in the leaf
  float slopeX, slopeY;
  uint from; // side from which the ray comes, see leaf/hit_rule.h
};

/* Stores the hit and returns true if it is nearer than the stored one by paper/nearest_hit.h, without its order of
 * blocks. framed: comparedT and hitT of that rule for the stored hit. numLeaves: per side. */
bool cbvhReport(BlockHeader header, uint geomID, CbvhPreparedRay ray, CbvhLocalRay local, uint numLeaves,
                CbvhLeafHit at, inout CbvhHit hit, inout vec2 framed) {
  float own = min(max(worldT(local.segment, at.s) * local.scale, ray.tnear), ray.tfar),
        t = min(max(own, ray.entryT), ray.tfar);
  if (t > hit.t || (t == hit.t && hit.t == framed.x && own >= framed.y)) return false;
  framed = vec2(t, own);
  uint height = heightOf(header.info);
  float size = float(1u << height) / float(numLeaves); // side of a leaf, in quads
  float u = faceParameter(cornerUOf(header.tiling), blockXOf(header.info), lastXOf(header.tiling), height,
                          size * (float(mortonX(at.leaf)) + at.u));
  float v = faceParameter(cornerVOf(header.tiling), blockYOf(header.info), lastYOf(header.tiling), height,
                          size * (float(mortonY(at.leaf)) + at.v));
  Vector p;
  for (int k = 0; k < 3; k++) p.x[k] = segmentAt(local.segment, k, at.s);
  Vector n = worldNormal(header, p, at.slopeX, at.slopeY);
  vec3 Ng = vec3(n.x[0], n.x[1], n.x[2]);
  Ng *= 1.0 / max(max(abs(Ng.x), max(abs(Ng.y), abs(Ng.z))), 1e-37);
  float length2 = dot(Ng, Ng);
  if (length2 > 0.0) Ng *= inversesqrt(length2);
  vec3 dir = ray.dir * local.scale;
  float along = dot(Ng, dir), dir2 = dot(dir, dir);
  if (isMirrored(along, 1.0, dir2, at.from)) Ng -= 2.0 * along / dir2 * dir;
  cbvhSetHit(hit, ray, t, u, v, Ng, header.primID, geomID);
  return true;
}

/* Parameter s of the segment at or after distance t, with slack for rounding. */
float cbvhParameterAfter(Segment s, float t) {
  return t < s.t1 && s.t0 < s.t1 ? localFraction(s.w0, s.w1, (t - s.t0) / (s.t1 - s.t0)) + 1e-5 : 1.0;
}

/* A leaf of cVOXEL, whose box is the surface. */
LeafPatch cbvhSolidLeaf(NodeBox box) {
  LeafPatch leaf;
  leaf.box = box;
  for (int c = 0; c < 4; c++) leaf.z[c] = 0.0;
  leaf.thickness = 0.0;
  leaf.solid = true;
  leaf.empty = false;
  return leaf;
}

CbvhLeafHit cbvhHitOnPatch(CbvhLocalRay local, LeafPatch patch_, uint leaf, float s, uint from) {
  float u = positionInBox(local.segment, patch_.box, 0, s), v = positionInBox(local.segment, patch_.box, 1, s);
  return CbvhLeafHit(s, leaf, u, v, patchSlope(patch_, 0, v), patchSlope(patch_, 1, u), from);
}

/* Intersects the triangles of a leaf of cGRID. leafOffset: byte offset of the block's vertices. numLeaves: per side. */
bool cbvhFramedGridLeaf(CbvhPointer block, BlockHeader header, uint leafOffset, uint numLeaves, CbvhPreparedRay ray,
                        uint leaf, const bool anyHit, inout CbvhHit hit) {
  uint height = heightOf(header.info), width = (1u << height) + 1u, plane = width * width, first = leafOffset / 4u;
  uint side = (1u << height) / numLeaves, quads = side * side;
  uint x0 = side * mortonX(leaf), y0 = side * mortonY(leaf);
  bool found = false;
  for (uint triangle = 0u; triangle < 2u * quads; triangle++) {
    uint q = triangle >> 1, x = x0 + q % side, y = y0 + q / side, i = y * width + x;
    bool second = (triangle & 1u) != 0u;
    uvec3 corners = cbvhQuadTriangle(i, width, second);
    CbvhTriangleHit at;
    if (!cbvhPluecker(ray, hit.t, cbvhGridVertex(block, first, plane, corners.x),
                      cbvhGridVertex(block, first, plane, corners.y), cbvhGridVertex(block, first, plane, corners.z),
                      at))
      continue;
    found = true;
    float w = 1.0 - at.u - at.v, X = float(x), Y = float(y);
    float px = second ? w * X + at.u * (X + 1.0) + at.v * (X + 1.0) : w * X + at.u * (X + 1.0) + at.v * X;
    float py = second ? w * (Y + 1.0) + at.u * Y + at.v * (Y + 1.0) : w * Y + at.u * Y + at.v * (Y + 1.0);
    cbvhSetHit(hit, ray, at.t,
               faceParameter(cornerUOf(header.tiling), blockXOf(header.info), lastXOf(header.tiling), height, px),
               faceParameter(cornerVOf(header.tiling), blockYOf(header.info), lastYOf(header.tiling), height, py),
               at.Ng, header.primID, block.geomID);
    if (anyHit) return true;
  }
  return found;
}

/* Intersects a block. kind: of the block; a constant if the scene contains only one kind with frames. */
bool cbvhTraceFramed(SceneData scene, CbvhPointer block, uint kind, CbvhPreparedRay ray, const bool anyHit,
                     inout CbvhHit hit, inout vec2 framed) {
  BlockHeader header = cbvhReadHeader(block);
  if (!cbvhIsVisible(scene, ray, block.geomID)) return false;

  CbvhLocalRay local;
  vec3 size = abs(ray.dir);
  float rcpScale = max(size.x, max(size.y, size.z));
  local.scale = 1.0 / rcpScale;
  WorldRay world;
  for (int k = 0; k < 3; k++) {
    world.org[k] = ray.org[k];
    world.dir[k] = ray.dir[k] * local.scale;
  }
  world.tnear = ray.tnear * rcpScale;
  world.tfar = ray.tfar * rcpScale; // not hit.t, so that hits are independent of the order of blocks
  local.segment = enterBlock(header, world, 1.0);
  if (!local.segment.valid || local.segment.t0 > hit.t * rcpScale) return false;

  vec3 D;
  for (int k = 0; k < 3; k++) {
    float d = local.segment.P1[k] - local.segment.P0[k];
    D[k] = d;
    local.lower[k] = local.segment.P0[k] - local.segment.epsilon[k];
    local.upper[k] = local.segment.P0[k] + local.segment.epsilon[k];
    local.rcp[k] = d < 0.0 ? 1.0 / min(d, -1e-18) : 1.0 / max(d, 1e-18);
  }
  local.flip = (D.x < 0.0 ? 1u : 0u) | (D.y < 0.0 ? 2u : 0u);
  bool isDown = D.z < 0.0;

  BlockLayout layout_ = blockLayout(kind, heightOf(header.info));
  uint nodeLevels = layout_.nodeLevels;
  WalkState state = startOfWalk();
  CbvhLeafHit exit_ = CbvhLeafHit(0.0, 0u, 0.0, 0.0, 0.0, 0.0, sideUnknown);
  /* parameter of the nearest hit; in cLEAF, of this block only */
  float best =
      kind != kindLeaf && hit.t < ray.tfar ? min(cbvhParameterAfter(local.segment, hit.t * rcpScale), 1.0) : 1.0;
  bool found = false;

  uint depth = 0u, m = 0u, hits = 0u, passed = 0u;
  NodeBox box = rootBox();
  bool isBoxKnown = true, isOpen = false;

  if (nodeLevels == 0u) // a single leaf of cGRID or cVOXEL
  {
    if (!isOnSegment(rangeInBox(local.segment, box, 3))) return false;
    if (kind == kindGrid)
      return cbvhFramedGridLeaf(block, header, layout_.leafOffset, layout_.leavesPerSide, ray, 0u, anyHit, hit);
    if (kind == kindVoxel) {
      Range range = rangeInBox(local.segment, box, 3);
      if (local.segment.startClipped && range.lower < 0.0) return false;
      return cbvhReport(header, block.geomID, ray, local, 1u,
                        cbvhHitOnPatch(local, cbvhSolidLeaf(box), 0u, max(range.lower, 0.0), sideUnknown), hit, framed);
    }
    return false;
  }

  while (true) {
    if (!isBoxKnown) {
      box = cbvhBoxOfNode(block, depth, m);
      isBoxKnown = true;
    }
    uint shift = 4u * depth;
    bool isLast = depth + 1u == nodeLevels, isGroup = isLast && kind == kindLeaf;
    uint word = cbvhNodeWord(block, depth, m);
    Heights heights;
    heights.low = heights.high = 0u;
    if (isGroup) {
      heights.low = cbvhWord(block, layout_.leafOffset / 4u + 2u * m);
      heights.high = cbvhWord(block, layout_.leafOffset / 4u + 2u * m + 1u);
    }
    CbvhSlabs slabs;
    if (isGroup) slabs = cbvhGroupSlabs(local, word, heights, box);
    else slabs = cbvhNodeSlabs(local, word, box);

    if (!isOpen) {
      isOpen = true;
      uint entered = cbvhMask(lessThanEqual(max(slabs.enter, vec4(0.0)), min(slabs.leave, vec4(best))));
      uint overOrUnder =
          cbvhMask(lessThanEqual(max(slabs.enterXY, vec4(0.0)), min(slabs.leaveXY, vec4(best)))) & ~entered;
      hits |= cbvhToOrder(entered, local.flip) << shift;
      if (kind == kindLeaf) passed |= cbvhToOrder(overOrUnder, local.flip) << shift;
    }

    bool descends = false;
    while (true) {
      uint hitChildren = (hits >> shift) & 15u, passedChildren = (passed >> shift) & 15u;
      uint events = kind == kindLeaf && needsPassedBoxes(state) ? hitChildren | passedChildren : hitChildren;
      if (events == 0u) break;
      uint i = uint(findLSB(events));
      uint before = (2u << i) - 1u;
      if (i == 1u && ((hitChildren | passedChildren) & 4u) != 0u &&
          slabs.enter[int(2u ^ local.flip)] < slabs.enter[int(1u ^ local.flip)]) {
        /* the ray enters child 2 before child 1; 5: bits of the children 0 and 2 */
        if ((events & 4u) != 0u) {
          i = 2u;
          before = 5u;
        } else before = 7u;
      } else if (i == 2u && ((hitChildren | passedChildren) & 2u) != 0u &&
                 slabs.enter[int(2u ^ local.flip)] < slabs.enter[int(1u ^ local.flip)])
        before = 5u;
      hits &= ~(before << shift);
      passed &= ~(before << shift);

      int child = int(i ^ local.flip);
      if ((hitChildren & (1u << i)) == 0u) {
        bool above = (slabs.leaveZ[child] < max(slabs.enterXY[child], 0.0)) != isDown;
        HitResult result = passBox(state, above);
        state = result.next;
        if (result.hit == hitNone) continue;
        exit_.from = result.from;
        /* continues as if this hit were the nearest, so that hits do not depend on the order of blocks */
        if (cbvhReport(header, block.geomID, ray, local, layout_.leavesPerSide, exit_, hit, framed)) found = true;
        if (anyHit) return true;
        best = exit_.s;
        state = afterHit(state);
        continue;
      }
      if (slabs.enter[child] > best) continue;
      if (!isLast) {
        box = decodeChild(word, child, box);
        m = 4u * m + uint(child);
        depth++;
        isOpen = false;
        descends = true;
        break;
      }

      uint leaf = 4u * m + uint(child);
      if (kind == kindGrid) {
        if (!cbvhFramedGridLeaf(block, header, layout_.leafOffset, layout_.leavesPerSide, ray, leaf, anyHit, hit))
          continue;
        found = true;
        if (anyHit) return true;
        best = cbvhParameterAfter(local.segment, hit.t * rcpScale);
      } else if (kind == kindVoxel) {
        float s = max(slabs.enter[child], 0.0);
        if (local.segment.startClipped && slabs.enter[child] < 0.0) continue;
        if (found ? !(s < best) : !(s <= best)) continue; // accepts the first of equal distances
        if (cbvhReport(header, block.geomID, ray, local, layout_.leavesPerSide,
                       cbvhHitOnPatch(local, cbvhSolidLeaf(decodeChild(word, child, box)), leaf, s, sideUnknown), hit,
                       framed))
          found = true;
        if (anyHit) return true;
        best = s;
      } else {
        LeafPatch patch_ = decodeLeaf(word, heights, child, box);
        Crossing x = crossPatch(local.segment, patch_);
        HitResult result = crossLeaf(state, x.event);
        bool hitsLeaf = result.hit != hitNone;
        float s = x.s0;
        if (result.hit == hitRoot) s = x.s0 + parabolaRoot(x.f) * (x.s1 - x.s0);
        if (result.hit == hitLip) {
          Lip lip = Lip(borderWidthOf(header.info), 0.5 * patch_.thickness, local.segment.epsilon[2]);
          LipIntersection at = intersectLipsOfLeaf(x, mortonX(leaf), mortonY(leaf), layout_.leavesPerSide - 1u, lip);
          hitsLeaf = at.hit;
          s = x.s0 + at.k * (x.s1 - x.s0);
        }
        if (hitsLeaf && !(state.found && !(s < best))) {
          if (cbvhReport(header, block.geomID, ray, local, layout_.leavesPerSide,
                         cbvhHitOnPatch(local, patch_, leaf, s, result.from), hit, framed))
            found = true;
          if (anyHit) return true;
          best = s;
          state = afterHit(state);
          continue;
        }
        state = result.next;
        if (state.pending) exit_ = cbvhHitOnPatch(local, patch_, leaf, x.s1, sideUnknown);
      }
    }
    if (descends) continue;

    bool isDone = true;
    while (true) {
      hits &= ~(15u << (4u * depth));
      passed &= ~(15u << (4u * depth));
      if (depth == 0u) break;
      depth--;
      m >>= 2;
      uint rest = (hits >> (4u * depth)) & 15u;
      if (kind == kindLeaf && needsPassedBoxes(state)) rest |= (passed >> (4u * depth)) & 15u;
      if (rest != 0u) {
        isDone = false;
        break;
      }
    }
    if (isDone) return found;
    isBoxKnown = false;
    isOpen = true;
  }
  return found;
}

#endif
