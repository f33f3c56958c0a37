// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A ray through a block of cVERT: kernels/cvert/rule/rule.h says by which rule its triangles are hit. Vertices of a block that does
 * not move are decoded a row at a time, and tested as they come; those of one that moves are kept, a group at a time. What a ray may hit is
 * then looked at again, exactly. */

#ifndef CBVH_VERT_BLOCK_GLSL
#define CBVH_VERT_BLOCK_GLSL

#include "vert_motion.glsl"

/* The ray sheared to the z axis: kz is the axis of the direction's largest component. */
struct CbvhShear
{
  int kz;
  float sx, sy;
};

/* components along kx, ky and kz */
vec3 cbvhTurn (int kz, vec3 v) { return kz == 2 ? v : kz == 0 ? v.yzx : v.zxy; }

CbvhShear cbvhShear (vec3 dir)
{
  vec3 a = abs(dir);
  CbvhShear shear;
  shear.kz = largestAxis(a.x, a.y, a.z);
  vec3 d = cbvhTurn(shear.kz, dir);
  float sz = 1.0/d.z;
  shear.sx = d.x*sz;
  shear.sy = d.y*sz;
  return shear;
}

vec2 cbvhSheared (CbvhShear shear, vec3 org, vec3 vertex)
{
  precise vec3 r = cbvhTurn(shear.kz, vertex - org);
  precise vec2 products = vec2(shear.sx*r.z, shear.sy*r.z);
  precise vec2 at = r.xy - products;
  return at;
}

/* Vertex i, j of group gx, gy in the world. moves: whether the block does, a constant; its group is decoded then */
vec3 cbvhGroupVertex (CbvhVertBlock block, CodedCell cell, CellRow row, uint gx, uint gy, int i, int j,
                      const bool moves)
{
  if (moves) return cbvhVerticesNow[5*j + i];
  if (block.hasRaw) return cbvhRawVertex(block, block.first, gx, gy, i, j);
  return cbvhWorldVertex(block, block.first, gx, gy, i, j, vertexOfRow(block.at, cell, row, i, j));
}

vec3 cbvhGroupVertex (CbvhVertBlock block, CodedCell cell, uint gx, uint gy, int i, int j, const bool moves) {
  return cbvhGroupVertex(block, cell, rowOfCell(cell, j), gx, gy, i, j, moves);
}

/* --- triangles ------------------------------------------------------------------------- */

float cbvhSide (vec2 a, vec2 b) { return edgeSide(a.x, a.y, b.x, b.y); }

/* Quads of a group whose triangles may have the ray's line in them: bit 2q + 0 or 1 of quad q. */
uint cbvhTriangles (CbvhVertBlock block, CodedCell cell, CbvhTravel ray, CbvhShear shear, uint gx, uint gy,
                    const bool moves)
{
  uint mask = 0u;
  int quadsX = int(quadsOfGroup(block.quadsX, gx)), quadsY = int(quadsOfGroup(block.quadsY, gy));
  vec2 below[5];
  CellRow first = rowOfCell(cell, 0);
  [[unroll]] for (int i = 0; i < 5; i++) below[i] = cbvhSheared(shear, ray.org, cbvhGroupVertex(block, cell, first, gx, gy, i, 0, moves));
  [[dont_unroll]] for (int j = 0; j < quadsY; j++)
  {
    vec2 row[5];
    CellRow above = rowOfCell(cell, j + 1);
    [[unroll]] for (int i = 0; i < 5; i++) row[i] = cbvhSheared(shear, ray.org, cbvhGroupVertex(block, cell, above, gx, gy, i, j + 1, moves));
    vec2 lower = min(below[0], row[0]), upper = max(below[0], row[0]);
    [[unroll]] for (int i = 1; i < 5; i++) {
      lower = min(lower, min(below[i], row[i]));
      upper = max(upper, max(below[i], row[i]));
    }
    if (block.hasRaw || (all(lessThanEqual(lower, vec2(0.0))) && all(greaterThanEqual(upper, vec2(0.0)))))
    [[unroll]] for (int i = 0; i < 4; i++) {
      float diag = cbvhSide(below[i + 1], row[i]), left = cbvhSide(row[i], below[i]), bottom = cbvhSide(below[i], below[i + 1]);
      float right = cbvhSide(below[i + 1], row[i + 1]), top = cbvhSide(row[i + 1], row[i]);
      uint bit = 2u*uint(4*j + i);
      if (isInside(diag, left, bottom)) mask |= 1u << bit;
      if (isInside(right, top, -diag)) mask |= 2u << bit;
    }
    [[unroll]] for (int i = 0; i < 5; i++) below[i] = row[i];
  }
  if (quadsX < 4) { // what is behind the last column has no area
    uint columns = (1u << (2*quadsX)) - 1u;
    mask &= columns*0x01010101u;
  }
  return mask;
}

WideTriangle cbvhWideTriangle (vec3 a, vec3 b, vec3 c)
{
  WideTriangle triangle;
  for (int k = 0; k < 3; k++) {
    triangle.at[k][0] = Wide(a[k]);
    triangle.at[k][1] = Wide(b[k]);
    triangle.at[k][2] = Wide(c[k]);
  }
  return triangle;
}

/* The triangle of a ray's nearest hit, if that is one of cVERT: of hits at the same distance one counts, by its name. */
struct CbvhVertNearest
{
  bool isSet;
  uint instID;
  float t;
  TriangleName name;
};

CbvhVertNearest cbvhNoVertNearest () { return CbvhVertNearest(false, 0u, 0.0, TriangleName(0u, 0u, 0u, 0u)); }

/* Triangle h of a group, bits as of cbvhTriangles; true if it is hit. */
bool cbvhHitTriangle (CbvhVertBlock block, CodedCell cell, CbvhTravel ray, CbvhShear shear, uint gx, uint gy, uint h,
                      const bool moves, inout CbvhHit hit, inout CbvhVertNearest nearest)
{
  int i = int(quadXOfTriangle(h)), j = int(quadYOfTriangle(h));
  vec3 vertices[3];
  [[unroll]] for (int v = 0; v < 3; v++) {
    int corner = int(cornerOfTriangle(h, v));
    vertices[v] = cbvhGroupVertex(block, cell, gx, gy, i + (corner & 1), j + (corner >> 1), moves);
  }
  vec3 a = vertices[0], b = vertices[1], c = vertices[2];
  if (block.hasRaw && !(cbvhIsFinite(a) && cbvhIsFinite(b) && cbvhIsFinite(c))) return false;
  vec2 A = cbvhSheared(shear, ray.org, a), B = cbvhSheared(shear, ray.org, b), C = cbvhSheared(shear, ray.org, c);
  TriangleSides sides = triangleSides(A.x, A.y, B.x, B.y, C.x, C.y);
  if (!areCertain(sides) && !contains(A.x, A.y, B.x, B.y, C.x, C.y)) return false;

  WideTriangle triangle = cbvhWideTriangle(a, b, c);
  WideNormal normal = normalOf(triangle);
  int kz = shear.kz;
  Wide org[3], dir[3];
  for (int k = 0; k < 3; k++) { org[k] = Wide(ray.org[k]); dir[k] = Wide(ray.dir[k]); }
  TriangleSpan span = spanOf(triangle.at[kz][0], triangle.at[kz][1], triangle.at[kz][2], org[kz], dir[kz]);
  Wide exact = distanceOfHit(triangle, normal, span, org, dir, Wide(ray.tnear));
  uint lane = gx + 4u*gy;
  TriangleName name = TriangleName(block.geomID, CVERT_AT(VertHeader, block.at).primID, block.region, 32u*lane + h);
  uint place = placeOfHit(exact, ray.tnear, hit.t, nearest.isSet && nearest.t == hit.t && nearest.instID == ray.instID);
  if (place == hitIsOutside || (place == hitIsTied && !comesBefore(name, nearest.name))) return false;

  float t = float(exact);
  SurfacePoint point = surfacePoint(block.at, lane, h, positionInQuad(sides, (h & 1u) != 0u));
  vec3 Ng = vec3(normal.at[0], normal.at[1], normal.at[2]);
  if (Ng == vec3(0.0)) Ng = -ray.dir;
  cbvhSetHit(hit, ray, t, point.u, point.v, Ng, point.primID, name.geomID);
  nearest = CbvhVertNearest(true, ray.instID, t, name);
  return true;
}

/* Of groups that a ray may meet, bit x + 4 y each, mirrored so that the nearer ones tend to come first; alongX, alongY: of the block */
uint cbvhMirror (CbvhTravel ray, vec3 alongX, vec3 alongY) {
  return (dot(alongX, ray.dir) < 0.0 ? 3u : 0u) | (dot(alongY, ray.dir) < 0.0 ? 12u : 0u);
}

/* groups of a block that does not move that the ray meets */
uint cbvhGroups (CbvhVertBlock block, CodedCell first, CbvhTravel ray, CbvhVertRay vert, CbvhVertAxes axes,
                 float tfar, uint mirror)
{
  uint open = 0u;
  if (block.hasRaw) {
    for (uint g = 0u; g < block.groups; g++)
      if (cbvhMeetsRawGroup(block, ray, vert, tfar, g)) open |= 1u << ((g % block.groupsX + 4u*(g/block.groupsX)) ^ mirror);
    return open;
  }
  ivec3 below[5];
  CellRow firstRow = rowOfCell(first, 0);
  [[unroll]] for (int i = 0; i < 5; i++) below[i] = vertexOfRow(block.at, first, firstRow, i, 0);
  [[dont_unroll]] for (uint gy = 0u; gy < block.groupsY; gy++)
  {
    ivec3 row[5];
    CellRow above = rowOfCell(first, int(gy) + 1);
    [[unroll]] for (int i = 0; i < 5; i++) row[i] = vertexOfRow(block.at, first, above, i, int(gy) + 1);
    [[unroll]] for (int i = 0; i < 4; i++)
      if (uint(i) < block.groupsX &&
          cbvhMeetsGroup(block, ray, vert, axes, tfar, gy*block.groupsX + uint(i), below[i], below[i + 1], row[i], row[i + 1]))
        open |= 1u << ((uint(i) + 4u*gy) ^ mirror);
    [[unroll]] for (int i = 0; i < 5; i++) below[i] = row[i];
  }
  return open;
}

/* Triangles of a group; true if one is hit. There is one way out of loops here and below: lavapipe (Mesa 22.3) loses hits of
 * rays that return from several at once while others go on. */
bool cbvhTraceGroup (CbvhVertBlock block, CodedCell cell, CbvhTravel ray, CbvhShear shear, uint gx, uint gy,
                     const bool anyHit, const bool moves, inout CbvhHit hit, inout CbvhVertNearest nearest)
{
  bool found = false;
  uint triangles = cbvhTriangles(block, cell, ray, shear, gx, gy, moves);
  while (triangles != 0u)
  {
    uint h = uint(findLSB(triangles));
    triangles &= triangles - 1u;
    if (!cbvhHitTriangle(block, cell, ray, shear, gx, gy, h, moves, hit, nearest)) continue;
    found = true;
    if (anyHit) triangles = 0u;
  }
  return found;
}

/* True if something is hit nearer than hit.t, which is lowered. */
bool cbvhTraceVert (SceneData scene, CbvhPointer at, CbvhTravel ray, const bool anyHit, inout CbvhHit hit, inout CbvhVertNearest nearest)
{
  if (!cbvhIsSeen(scene, ray, at.geomID)) return false;
  CbvhVertBlock block = cbvhReadVertBlock(at);
  CbvhShear shear = cbvhShear(ray.dir);
  CbvhVertRay vert = cbvhVertRay(ray);
  CbvhVertAxes axes = CbvhVertAxes(0u, vec3(0.0), 0.0, 0.0, 0.0, 0.0);
  CodedCell first = cbvhNoCell();
  if (!block.hasRaw) {
    BlockReach reach = reachAtBegin(block.first);
    axes = cbvhVertAxes(block.boxForm, cbvhOrigin(block.first), extentOfReach(reach), ray, vert);
    if (!cbvhMeetsBounds(ray, vert, axes, reach, vec3(0.0), hit.t)) return false;
    first = firstCell(block.first, block.region);
  }
  vec3 spacing = cbvhSpacing(block.first);
  uint mirror = cbvhMirror(ray, vec3(first.c10 - first.c00)*spacing, vec3(first.c01 - first.c00)*spacing);
  uint open = cbvhGroups(block, first, ray, vert, axes, hit.t, mirror);
  bool found = false;
  while (open != 0u && !(anyHit && found))
  {
    uint lane = uint(findLSB(open)) ^ mirror, gx = lane & 3u, gy = lane >> 2;
    open &= open - 1u;
    CodedCell cell = first;
    if (!block.hasRaw) {
      cell = cbvhGroupCell(block, first, gx, gy);
      if (found && !cbvhMeetsGroup(block, ray, vert, axes, hit.t, gy*block.groupsX + gx,
                                   cell.c00, cell.c10, cell.c01, cell.c11)) continue;
    }
    if (cbvhTraceGroup(block, cell, ray, shear, gx, gy, anyHit, false, hit, nearest)) found = true;
  }
  return found;
}

/* the same of a block that moves */
bool cbvhTraceMovingVert (SceneData scene, CbvhPointer at, CbvhTravel ray, const bool anyHit, inout CbvhHit hit, inout CbvhVertNearest nearest)
{
  if (!cbvhIsSeen(scene, ray, at.geomID)) return false;
  CbvhVertBlock block = cbvhReadVertBlock(at);
  CbvhSegment segment;
  if (!cbvhFindSegment(block, ray.time, segment)) return false;
  CbvhShear shear = cbvhShear(ray.dir);
  CbvhVertRay vert = cbvhVertRay(ray);
  CbvhVertAxes axes = CbvhVertAxes(0u, vec3(0.0), 0.0, 0.0, 0.0, 0.0);
  vec3 slack = vec3(0.0);
  if (!block.hasRaw) {
    axes = cbvhAxesNow(segment, ray, vert);
    slack = cbvhMotionSlack(segment, axes);
    if (!cbvhMeetsBlockNow(segment, ray, vert, axes, slack, hit.t)) return false;
  }
  cbvhDecodeCorners(block, segment);
  uint mirror = 0u;
  if (!block.hasRaw) {
    ivec3 corner = cbvhCornersAtEnds[0][0];
    vec3 spacing = cbvhSpacing(segment.begin);
    mirror = cbvhMirror(ray, vec3(cbvhCornersAtEnds[0][block.groupsX] - corner)*spacing, vec3(cbvhCornersAtEnds[0][5u*block.groupsY] - corner)*spacing);
  }
  bool found = false;
  [[dont_unroll]] for (uint i = 0u; i < maxVertGroups && !(anyHit && found); i++)
  {
    uint lane = i ^ mirror, gx = lane & 3u, gy = lane >> 2;
    if (gx >= block.groupsX || gy >= block.groupsY) continue;
    if (!block.hasRaw && !cbvhMeetsGroupNow(block, segment, ray, vert, axes, slack, hit.t, gx, gy)) continue;
    cbvhDecodeGroup(block, segment, gx, gy);
    if (cbvhTraceGroup(block, cbvhNoCell(), ray, shear, gx, gy, anyHit, true, hit, nearest)) found = true;
  }
  return found;
}

#endif
