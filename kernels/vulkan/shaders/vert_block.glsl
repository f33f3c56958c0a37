// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Intersects a ray with a cVERT block, as kernels/cvert/rule/rule.h defines. Decodes vertices row by row, or group by
 * group if the block moves. Tests in float select candidates, which are then tested exactly. */

#ifndef CBVH_VERT_BLOCK_GLSL
#define CBVH_VERT_BLOCK_GLSL

#include "vert_motion.glsl"
#include "vert_triangle.glsl"

/* World position of vertex i, j of group gx, gy. moves: compile-time constant; if true, requires cbvhDecodeGroup. */
vec3 cbvhGroupVertex(CbvhVertBlock block, CodedCell cell, CellRow row, uint gx, uint gy, int i, int j,
                     const bool moves) {
  if (moves) return cbvhVerticesAtTime[5 * j + i];
  if (block.hasRaw) return cbvhRawVertex(block, block.firstStep, gx, gy, i, j);
  return cbvhWorldVertex(block, block.firstStep, gx, gy, i, j, vertexOfRow(block.at, cell, row, i, j));
}

vec3 cbvhGroupVertex(CbvhVertBlock block, CodedCell cell, uint gx, uint gy, int i, int j, const bool moves) {
  return cbvhGroupVertex(block, cell, rowOfCell(cell, j), gx, gy, i, j, moves);
}

/* --- triangles ------------------------------------------------------------------------- */

/* Returns a mask of the triangles that the ray's line may pass through: bits 2q and 2q + 1 for quad q = i + 4j. */
uint cbvhCandidateTriangles(CbvhVertBlock block, CodedCell cell, CbvhPreparedRay ray, CbvhShear shear, uint gx, uint gy,
                            const bool moves) {
  uint mask = 0u;
  int quadsX = int(quadsOfGroup(block.quadsX, gx)), quadsY = int(quadsOfGroup(block.quadsY, gy));
  vec2 below[5];
  CellRow first = rowOfCell(cell, 0);
  [[unroll]] for (int i = 0; i < 5; i++)
    below[i] = cbvhSheared(shear, ray.org, cbvhGroupVertex(block, cell, first, gx, gy, i, 0, moves));
  [[dont_unroll]] for (int j = 0; j < quadsY; j++) {
    vec2 row[5];
    CellRow above = rowOfCell(cell, j + 1);
    [[unroll]] for (int i = 0; i < 5; i++)
      row[i] = cbvhSheared(shear, ray.org, cbvhGroupVertex(block, cell, above, gx, gy, i, j + 1, moves));
    vec2 lower = min(below[0], row[0]), upper = max(below[0], row[0]);
    [[unroll]] for (int i = 1; i < 5; i++) {
      lower = min(lower, min(below[i], row[i]));
      upper = max(upper, max(below[i], row[i]));
    }
    if (block.hasRaw || (all(lessThanEqual(lower, vec2(0.0))) && all(greaterThanEqual(upper, vec2(0.0)))))
      mask |= cbvhRowTriangles(below, row) << (8 * j);
    [[unroll]] for (int i = 0; i < 5; i++)
      below[i] = row[i];
  }
  if (quadsX < 4) { // quads after the last column are degenerate
    uint columns = (1u << (2 * quadsX)) - 1u;
    mask &= columns * 0x01010101u;
  }
  return mask;
}

/* Tests a triangle of group gx, gy exactly. triangle: index of its bit in cbvhCandidateTriangles. */
bool cbvhIntersectTriangleOfGroup(CbvhVertBlock block, CodedCell cell, CbvhPreparedRay ray, CbvhShear shear, uint gx,
                                  uint gy, uint triangle, const bool moves, inout CbvhHit hit,
                                  inout CbvhVertNearest nearest) {
  int i = int(quadXOfTriangle(triangle)), j = int(quadYOfTriangle(triangle));
  vec3 vertices[3];
  [[unroll]] for (int v = 0; v < 3; v++) {
    int corner = int(cornerOfTriangle(triangle, v));
    vertices[v] = cbvhGroupVertex(block, cell, gx, gy, i + (corner & 1), j + (corner >> 1), moves);
  }
  return cbvhIntersectQuadTriangle(block.at, block.geomID, ray, shear, gx + 4u * gy, triangle, vertices[0], vertices[1],
                                   vertices[2], block.hasRaw, hit, nearest);
}

/* Returns m such that the order 0 ^ m, 1 ^ m, ... of groups x + 4y tends to be front to back. alongX, alongY: world
 * directions of rows and columns. */
uint cbvhMirror(CbvhPreparedRay ray, vec3 alongX, vec3 alongY) {
  return (dot(alongX, ray.dir) < 0.0 ? 3u : 0u) | (dot(alongY, ray.dir) < 0.0 ? 12u : 0u);
}

/* Returns a mask of the groups of a static block whose boxes the ray hits: bit (x + 4y) ^ mirror for group x, y. */
uint cbvhIntersectGroups(CbvhVertBlock block, CodedCell first, CbvhPreparedRay ray, CbvhVertRay vert, CbvhVertAxes axes,
                         float tfar, uint mirror) {
  uint groups = 0u;
  if (block.hasRaw) {
    for (uint g = 0u; g < block.groups; g++)
      if (cbvhIntersectsRawGroup(block, ray, vert, tfar, g))
        groups |= 1u << ((g % block.groupsX + 4u * (g / block.groupsX)) ^ mirror);
    return groups;
  }
  ivec3 below[5];
  CellRow firstRow = rowOfCell(first, 0);
  [[unroll]] for (int i = 0; i < 5; i++)
    below[i] = vertexOfRow(block.at, first, firstRow, i, 0);
  [[dont_unroll]] for (uint gy = 0u; gy < block.groupsY; gy++) {
    ivec3 row[5];
    CellRow above = rowOfCell(first, int(gy) + 1);
    [[unroll]] for (int i = 0; i < 5; i++)
      row[i] = vertexOfRow(block.at, first, above, i, int(gy) + 1);
    [[unroll]] for (int i = 0; i < 4; i++)
      if (uint(i) < block.groupsX && cbvhIntersectsGroup(block, ray, vert, axes, tfar, gy * block.groupsX + uint(i),
                                                         below[i], below[i + 1], row[i], row[i + 1]))
        groups |= 1u << ((uint(i) + 4u * gy) ^ mirror);
    [[unroll]] for (int i = 0; i < 5; i++)
      below[i] = row[i];
  }
  return groups;
}

/* Intersects the triangles of a group. Loops here and below have one exit: lavapipe (Mesa 22.3) loses hits of rays that
 * leave several loops at once while others continue. */
bool cbvhTraceGroup(CbvhVertBlock block, CodedCell cell, CbvhPreparedRay ray, CbvhShear shear, uint gx, uint gy,
                    const bool anyHit, const bool moves, inout CbvhHit hit, inout CbvhVertNearest nearest) {
  bool found = false;
  uint triangles = cbvhCandidateTriangles(block, cell, ray, shear, gx, gy, moves);
  while (triangles != 0u) {
    uint triangle = uint(findLSB(triangles));
    triangles &= triangles - 1u;
    if (!cbvhIntersectTriangleOfGroup(block, cell, ray, shear, gx, gy, triangle, moves, hit, nearest)) continue;
    found = true;
    if (anyHit) triangles = 0u;
  }
  return found;
}

bool cbvhTraceVert(SceneData scene, CbvhPointer at, CbvhPreparedRay ray, const bool anyHit, inout CbvhHit hit,
                   inout CbvhVertNearest nearest) {
  if (!cbvhIsVisible(scene, ray, at.geomID)) return false;
  CbvhVertBlock block = cbvhReadVertBlock(at);
  CbvhShear shear = cbvhShear(ray.dir);
  CbvhVertRay vert = cbvhVertRay(ray);
  CbvhVertAxes axes = CbvhVertAxes(0u, vec3(0.0), 0.0, 0.0, 0.0, 0.0);
  CodedCell first = cbvhNoCell();
  if (!block.hasRaw) {
    ShearedBounds bounds = boundsAtBegin(block.firstStep);
    axes = cbvhVertAxes(block.info, cbvhOrigin(block.firstStep), extentOfBounds(bounds), ray, vert);
    if (!cbvhIntersectsBounds(ray, vert, axes, bounds, vec3(0.0), hit.t)) return false;
    first = firstCell(block.firstStep, block.region);
  }
  vec3 spacing = cbvhSpacing(block.firstStep);
  uint mirror = cbvhMirror(ray, vec3(first.c10 - first.c00) * spacing, vec3(first.c01 - first.c00) * spacing);
  uint groups = cbvhIntersectGroups(block, first, ray, vert, axes, hit.t, mirror);
  bool found = false;
  while (groups != 0u && !(anyHit && found)) {
    uint lane = uint(findLSB(groups)) ^ mirror, gx = lane & 3u, gy = lane >> 2;
    groups &= groups - 1u;
    CodedCell cell = first;
    if (!block.hasRaw) {
      cell = cbvhGroupCell(block, first, gx, gy);
      if (found && !cbvhIntersectsGroup(block, ray, vert, axes, hit.t, gy * block.groupsX + gx, cell.c00, cell.c10,
                                        cell.c01, cell.c11))
        continue;
    }
    if (cbvhTraceGroup(block, cell, ray, shear, gx, gy, anyHit, false, hit, nearest)) found = true;
  }
  return found;
}

bool cbvhTraceMovingVert(SceneData scene, CbvhPointer at, CbvhPreparedRay ray, const bool anyHit, inout CbvhHit hit,
                         inout CbvhVertNearest nearest) {
  if (!cbvhIsVisible(scene, ray, at.geomID)) return false;
  CbvhVertBlock block = cbvhReadVertBlock(at);
  CbvhSegment segment;
  if (!cbvhFindSegment(block, ray.time, segment)) return false;
  CbvhShear shear = cbvhShear(ray.dir);
  CbvhVertRay vert = cbvhVertRay(ray);
  CbvhVertAxes axes = CbvhVertAxes(0u, vec3(0.0), 0.0, 0.0, 0.0, 0.0);
  vec3 slack = vec3(0.0);
  if (!block.hasRaw) {
    axes = cbvhAxesAtTime(segment, ray, vert);
    slack = cbvhMotionSlack(segment, axes);
    if (!cbvhIntersectsBlockAtTime(segment, ray, vert, axes, slack, hit.t)) return false;
  }
  cbvhDecodeCorners(block, segment);
  uint mirror = 0u;
  if (!block.hasRaw) {
    ivec3 corner = cbvhCornersAtEnds[0][0];
    vec3 spacing = cbvhSpacing(segment.begin);
    mirror = cbvhMirror(ray, vec3(cbvhCornersAtEnds[0][block.groupsX] - corner) * spacing,
                        vec3(cbvhCornersAtEnds[0][5u * block.groupsY] - corner) * spacing);
  }
  bool found = false;
  [[dont_unroll]] for (uint i = 0u; i < maxVertGroups && !(anyHit && found); i++) {
    uint lane = i ^ mirror, gx = lane & 3u, gy = lane >> 2;
    if (gx >= block.groupsX || gy >= block.groupsY) continue;
    if (!block.hasRaw && !cbvhIntersectsGroupAtTime(block, segment, ray, vert, axes, slack, hit.t, gx, gy)) continue;
    cbvhDecodeGroup(block, segment, gx, gy);
    if (cbvhTraceGroup(block, cbvhNoCell(), ray, shear, gx, gy, anyHit, true, hit, nearest)) found = true;
  }
  return found;
}

#endif
