// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A ray through a block of cVERT: kernels/cbvh/vert/format.h and cell.h say what the
 * bytes are, rule.h by which rule its triangles are hit. Vertices are decoded a row at a time, and tested as they come; what a
 * ray may hit is then looked at again, exactly. */

#ifndef CBVH_VERT_BLOCK_GLSL
#define CBVH_VERT_BLOCK_GLSL

#include "ray.glsl"
#include "../../cbvh/vert/rule.h"

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
  shear.kz = a.x >= a.y ? (a.x >= a.z ? 0 : 2) : (a.y >= a.z ? 1 : 2);
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

/* --- vertices -------------------------------------------------------------------------- */

struct CbvhVertBlock
{
  CbvhPointer at;
  vec3 origin;
  uint reach;
  uint region, boxForm, word;
  VertLayout offsets;
  uint quadsX, quadsY;
  float spacing;
};

CbvhVertBlock cbvhReadVertBlock (CbvhPointer at, uvec4 first)
{
  CbvhVertBlock block;
  block.at = at;
  block.origin = uintBitsToFloat(first.xyz);
  block.reach = first.w;
  block.region = cbvhWord(at, 6u);
  block.boxForm = cbvhWord(at, 14u);
  block.word = cbvhWord(at, 15u);
  block.offsets = vertLayout(block.region, block.boxForm);
  block.quadsX = vertQuadsX(block.region);
  block.quadsY = vertQuadsY(block.region);
  block.spacing = vertSpacing(block.word);
  return block;
}

/* A cell that is being decoded: its corners, and where its fields are. */
struct CbvhCell
{
  uint word;
  uint data;                   // byte of the first field
  ivec3 c00, c10, c01, c11;
  int step, quadsX, quadsY;
};

int cbvhWeight (int i, int step_, int quads) { return quads == 4*step_ ? 4*i : cellWeight(i, step_, quads); }

int cbvhResidual (CbvhPointer at, uint bit, int bits) { return bits == 0 ? 0 : cellResidual(cbvhBits(at, bit), 0, bits); }

/* Predictions of a row: (start + weight*slope) >> 8, which is cellPrediction of vertex_cell.h. */
struct CbvhRow
{
  ivec3 start, slope;
};

CbvhRow cbvhRow (CbvhCell cell, int j)
{
  int weightY = cbvhWeight(j, cell.step, cell.quadsY);
  CbvhRow row;
  row.start = 256*cell.c00 + 16*weightY*(cell.c01 - cell.c00) + 128;
  row.slope = 16*(cell.c10 - cell.c00) + weightY*(cell.c11 - cell.c10 - cell.c01 + cell.c00);
  return row;
}

/* coordinates of vertex i, j */
ivec3 cbvhRowVertex (CbvhPointer at, CbvhCell cell, CbvhRow row, int i, int j)
{
  ivec3 vertex = (row.start + cbvhWeight(i, cell.step, cell.quadsX)*row.slope) >> 8;
  int field = cellField(i, j);
  if (field < 0) return vertex;

  uint word = cell.word;
  int bits0 = cellBits(word, 0), bits1 = cellBits(word, 1), bits2 = cellBits(word, 2), bits = bits0 + bits1 + bits2;
  int r0, r1, r2;
  if (isByAxis(word)) {
    uint start = 8u*cell.data;
    r0 = cbvhResidual(at, start + uint(field*bits0), bits0);
    r1 = cbvhResidual(at, start + uint(cellFields*bits0 + field*bits1), bits1);
    r2 = cbvhResidual(at, start + uint(cellFields*(bits0 + bits1) + field*bits2), bits2);
  }
  else {
    uint residuals = bits == 0 ? 0u : cbvhBits(at, 8u*cell.data + uint(field*bits));
    r0 = cellResidual(residuals, 0, bits0);
    r1 = cellResidual(residuals, bits0, bits1);
    r2 = cellResidual(residuals, bits0 + bits1, bits2);
  }
  r1 += slopeResidual(cellSlope(word, 1), r0);
  r2 += slopeResidual(cellSlope(word, 2), r0);
  int axis = cellMainAxis(word);
  return vertex + (axis == 0 ? ivec3(r0, r1, r2) : axis == 1 ? ivec3(r2, r0, r1) : ivec3(r1, r2, r0));
}

ivec3 cbvhCellVertex (CbvhPointer at, CbvhCell cell, int i, int j) { return cbvhRowVertex(at, cell, cbvhRow(cell, j), i, j); }

ivec3 cbvhCorner (CbvhVertBlock block, int c)
{
  ivec3 corner;
  for (int k = 0; k < 3; k++) corner[k] = cornerCoordinate(cbvhWord(block.at, 8u + uint(cornerPair(c, k))), c, k);
  return corner;
}

/* the cell of the corners of groups */
CbvhCell cbvhFirstCell (CbvhVertBlock block)
{
  CbvhCell cell;
  cell.word = block.word;
  cell.data = block.offsets.cell;
  cell.c00 = cbvhCorner(block, 0);
  cell.c10 = cbvhCorner(block, 1);
  cell.c01 = cbvhCorner(block, 2);
  cell.c11 = cbvhCorner(block, 3);
  cell.step = int(groupQuads);
  cell.quadsX = int(block.quadsX);
  cell.quadsY = int(block.quadsY);
  return cell;
}

uint cbvhWordOfGroup (CbvhVertBlock block, uint g)
{
  uint low = cbvhWord(block.at, (block.offsets.words + 2u*g) >> 2) >> (8u*((block.offsets.words + 2u*g) & 3u)); // at even bytes
  return (low & 0xFFFFu) | (cbvhByte(block.at, block.offsets.wordsHigh + g) << 16);
}

CbvhCell cbvhGroupCell (CbvhVertBlock block, CbvhCell first, uint gx, uint gy)
{
  uint g = gy*block.offsets.groupsX + gx;
  CbvhCell cell;
  cell.data = block.offsets.cell + cellBytes(block.word);
  for (uint before = 0u; before < g; before++) cell.data += cellBytes(cbvhWordOfGroup(block, before));
  cell.word = cbvhWordOfGroup(block, g);
  cell.c00 = cbvhCellVertex(block.at, first, int(gx), int(gy));
  cell.c10 = cbvhCellVertex(block.at, first, int(gx) + 1, int(gy));
  cell.c01 = cbvhCellVertex(block.at, first, int(gx), int(gy) + 1);
  cell.c11 = cbvhCellVertex(block.at, first, int(gx) + 1, int(gy) + 1);
  cell.step = 1;
  cell.quadsX = int(quadsOfGroup(block.quadsX, gx));
  cell.quadsY = int(quadsOfGroup(block.quadsY, gy));
  return cell;
}

/* vertex i, j of group gx, gy in the world */
vec3 cbvhGroupVertex (CbvhVertBlock block, CbvhCell cell, CbvhRow row, uint gx, uint gy, int i, int j)
{
  if (isRaw(block.boxForm)) {
    uint x = min(groupQuads*gx + uint(i), block.quadsX), y = min(groupQuads*gy + uint(j), block.quadsY);
    uint first = block.offsets.vertices/4u + 3u*(y*(block.quadsX + 1u) + x);
    return vec3(cbvhFloat(block.at, first), cbvhFloat(block.at, first + 1u), cbvhFloat(block.at, first + 2u));
  }
  return block.origin + vec3(cbvhRowVertex(block.at, cell, row, i, j))*block.spacing;
}

vec3 cbvhGroupVertex (CbvhVertBlock block, CbvhCell cell, uint gx, uint gy, int i, int j) {
  return cbvhGroupVertex(block, cell, cbvhRow(cell, j), gx, gy, i, j);
}

/* --- boxes ----------------------------------------------------------------------------- */

/* The ray along a block's sheared coordinate, from the block's origin. */
struct CbvhShearedRay
{
  float org, rcp, error;
};

struct CbvhVertRay
{
  CbvhShear shear;
  vec3 rcp;        // finite
  float largest;   // of the components of the direction
};

int cbvhNextAxis (int axis, int by) { return axis + by < 3 ? axis + by : axis + by - 3; }

CbvhShearedRay cbvhShearedRay (CbvhVertBlock block, CbvhTravel ray, CbvhVertRay vert, float extent)
{
  ShearedCoordinate along = noShearedCoordinate();
  int m = shearedAxis(block.boxForm);
  for (int k = 0; k < 3; k++) {
    int i = k >= m ? k - m : k - m + 3;
    float shear = i == 0 ? 1.0 : float(shearSlope(block.boxForm, i))*(1.0/16.0);
    along = addSheared(along, ray.org[k], ray.dir[k], block.origin[k], extent, shear);
  }
  return CbvhShearedRay(along.org, directionReciprocal(along.dir, vert.largest), shearedSlack(along.size));
}

void cbvhClip (inout float tNear, inout float tFar, float lower, float upper, float rcp)
{
  float a = lower*rcp, b = upper*rcp;
  tNear = max(tNear, min(a, b));
  tFar = min(tFar, max(a, b));
}

float cbvhSlack (CbvhVertBlock block, CbvhTravel ray, int k, float extent) { return boxSlack(ray.org[k], block.origin[k], extent); }

/* whether the ray meets the bounds of a block that is not raw */
bool cbvhMeetsBlock (CbvhVertBlock block, CbvhTravel ray, CbvhVertRay vert, CbvhShearedRay sheared, float extent, float tfar)
{
  int m = shearedAxis(block.boxForm);
  float step_ = float(reachStep(block.boxForm))*block.spacing, tNear = ray.tnear, tFar = tfar;
  for (int i = 0; i < 2; i++) {
    int k = cbvhNextAxis(m, 1 + i);
    float from = block.origin[k] - ray.org[k], slack = cbvhSlack(block, ray, k, extent);
    cbvhClip(tNear, tFar, from - slack, (from + float(reachOf(block.reach, i))*step_) + slack, vert.rcp[k]);
  }
  cbvhClip(tNear, tFar, (float(reachOf(block.reach, 2))*step_ - sheared.org) - sheared.error,
           (float(reachOf(block.reach, 3))*step_ - sheared.org) + sheared.error, sheared.rcp);
  return tNear <= tFar;
}

float cbvhLeast (vec4 v) { return min(min(v.x, v.y), min(v.z, v.w)); }
float cbvhGreatest (vec4 v) { return max(max(v.x, v.y), max(v.z, v.w)); }

/* whether the ray meets the box of group g of a block that is not raw, whose corners are given */
bool cbvhMeetsGroup (CbvhVertBlock block, CbvhTravel ray, CbvhVertRay vert, CbvhShearedRay sheared, float extent, float tfar, uint g,
                     vec3 c00, vec3 c10, vec3 c01, vec3 c11)
{
  int m = shearedAxis(block.boxForm);
  float tNear = ray.tnear, tFar = tfar;
  for (int k = 0; k < 3; k++)
  {
    uint margins = cbvhByte(block.at, block.offsets.margins + uint(k)*block.offsets.groups + g), shift = marginShift(block.boxForm, k);
    vec4 corners = vec4(c00[k], c10[k], c01[k], c11[k]);
    bool isSheared = k == m;
    if (isSheared) {
      int n = cbvhNextAxis(m, 1), l = cbvhNextAxis(m, 2);
      corners += float(shearSlope(block.boxForm, 1))*(1.0/16.0)*vec4(c00[n], c10[n], c01[n], c11[n])
               + float(shearSlope(block.boxForm, 2))*(1.0/16.0)*vec4(c00[l], c10[l], c01[l], c11[l]);
    }
    float origin = isSheared ? 0.0 : block.origin[k], from = isSheared ? sheared.org : ray.org[k];
    float error = isSheared ? sheared.error : cbvhSlack(block, ray, k, extent);
    float lower = (cbvhLeast(corners) - float(lowerMargin(margins, shift)))*block.spacing + origin;
    float upper = (cbvhGreatest(corners) + float(upperMargin(margins, shift)))*block.spacing + origin;
    cbvhClip(tNear, tFar, (lower - from) - error, (upper - from) + error, isSheared ? sheared.rcp : vert.rcp[k]);
  }
  return tNear <= tFar;
}

bool cbvhMeetsRawGroup (CbvhVertBlock block, CbvhTravel ray, CbvhVertRay vert, float tfar, uint g)
{
  float tNear = ray.tnear, tFar = tfar;
  for (int k = 0; k < 3; k++) {
    uint first = block.offsets.boxes/4u;
    float lower = cbvhFloat(block.at, first + uint(k)*block.offsets.groups + g), upper = cbvhFloat(block.at, first + uint(3 + k)*block.offsets.groups + g);
    float highest = block.origin[k];
    for (uint i = 0u; i < block.offsets.groups; i++) highest = max(highest, cbvhFloat(block.at, first + uint(3 + k)*block.offsets.groups + i));
    float slack = cbvhSlack(block, ray, k, highest - block.origin[k]);
    cbvhClip(tNear, tFar, (lower - ray.org[k]) - slack, (upper - ray.org[k]) + slack, vert.rcp[k]);
  }
  return tNear <= tFar;
}

/* --- triangles ------------------------------------------------------------------------- */

float cbvhSide (vec2 a, vec2 b) { return edgeSide(a.x, a.y, b.x, b.y); }

/* Quads of a group whose triangles may have the ray's line in them: bit 2q + 0 or 1 of quad q. */
uint cbvhTriangles (CbvhVertBlock block, CbvhCell cell, CbvhTravel ray, CbvhShear shear, uint gx, uint gy)
{
  uint mask = 0u;
  int quadsX = int(quadsOfGroup(block.quadsX, gx)), quadsY = int(quadsOfGroup(block.quadsY, gy));
  vec2 below[5];
  CbvhRow first = cbvhRow(cell, 0);
  [[unroll]] for (int i = 0; i < 5; i++) below[i] = cbvhSheared(shear, ray.org, cbvhGroupVertex(block, cell, first, gx, gy, i, 0));
  [[dont_unroll]] for (int j = 0; j < quadsY; j++)
  {
    vec2 row[5];
    CbvhRow above = cbvhRow(cell, j + 1);
    [[unroll]] for (int i = 0; i < 5; i++) row[i] = cbvhSheared(shear, ray.org, cbvhGroupVertex(block, cell, above, gx, gy, i, j + 1));
    vec2 lower = min(below[0], row[0]), upper = max(below[0], row[0]);
    [[unroll]] for (int i = 1; i < 5; i++) {
      lower = min(lower, min(below[i], row[i]));
      upper = max(upper, max(below[i], row[i]));
    }
    if (all(lessThanEqual(lower, vec2(0.0))) && all(greaterThanEqual(upper, vec2(0.0))))
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

/* Parameters of the face at a position of quad x, y of the patch. */
vec2 cbvhVertParameters (CbvhVertBlock block, uint x, uint y, bool second, QuadPosition position)
{
  uint patchQuads = cbvhWord(block.at, 7u), cornerU = 0u, cornerV = 0u;
  if (hasEdges(block.boxForm)) {
    VertEdges edges = VertEdges(cbvhWord(block.at, 16u), cbvhWord(block.at, 17u));
    if (isAtLowerEdge(patchQuads, edges, x, y)) {
      FaceParameters parameters = parametersAtLowerEdge(patchQuads, edges, x, y, second, position.a, position.b);
      return vec2(parameters.u, parameters.v);
    }
    cornerU = vertCornerU(edges);
    cornerV = vertCornerV(edges);
  }
  return vec2(faceParameterOfQuad(cornerU, float(x), position.a, patchQuadsX(patchQuads)),
              faceParameterOfQuad(cornerV, float(y), position.b, patchQuadsY(patchQuads)));
}

/* The primitive of quad x, y of a block that numbers its quads, and the parameters of it at a position. */
uint cbvhOwnParameters (CbvhVertBlock block, uint x, uint y, bool second, QuadPosition position, out vec2 uv)
{
  uint form = cbvhWord(block.at, 7u), number = cbvhWord(block.at, 5u);
  VertNumbers numbers = VertNumbers(cbvhWord(block.at, 16u), cbvhWord(block.at, 17u));
  if (patternOfNumbers(form) == numbersInTable) {
    uint read = cbvhBits(block.at, 8u*numbers.x + numbers.y*(y*block.quadsX + x));
    number += numbers.y < 32u ? read & ((1u << numbers.y) - 1u) : read;
  }
  else number += patternNumber(form, numbers, x, y);
  OwnParameters own = ownParameters(form, second, inUnit(position.a), inUnit(position.b));
  uv = vec2(own.u, own.v);
  return primitiveOfNumber(form, number, second);
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
bool cbvhHitTriangle (CbvhVertBlock block, CbvhCell cell, CbvhTravel ray, CbvhShear shear, uint gx, uint gy, uint h, inout CbvhHit hit, inout CbvhVertNearest nearest)
{
  int i = int((h >> 1) & 3u), j = int(h >> 3);
  bool second = (h & 1u) != 0u;
  vec3 a = cbvhGroupVertex(block, cell, gx, gy, i, second ? j + 1 : j);
  vec3 b = cbvhGroupVertex(block, cell, gx, gy, i + 1, j);
  vec3 c = cbvhGroupVertex(block, cell, gx, gy, second ? i + 1 : i, j + 1);
  if (isRaw(block.boxForm) && !(cbvhIsFinite(a) && cbvhIsFinite(b) && cbvhIsFinite(c))) return false;
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
  if (!(exact >= Wide(ray.tnear))) return false;
  float t = float(exact);
  TriangleName name = TriangleName(block.at.geomID, cbvhWord(block.at, 5u), block.region, 32u*(gx + 4u*gy) + h);
  if (!(t < hit.t)) {
    if (nearest.isSet && nearest.t == hit.t && nearest.instID == ray.instID) {
      if (t != hit.t || !comesBefore(name, nearest.name)) return false;
    }
    else if (!(exact <= Wide(hit.t))) return false;
  }

  uint x = groupQuads*gx + uint(i), y = groupQuads*gy + uint(j), primID = name.primID;
  vec2 uv;
  if (hasNumbers(block.boxForm)) primID = cbvhOwnParameters(block, x, y, second, positionInQuad(sides, second), uv);
  else uv = cbvhVertParameters(block, vertX(block.region) + x, vertY(block.region) + y, second, positionInQuad(sides, second));
  vec3 Ng = vec3(normal.at[0], normal.at[1], normal.at[2]);
  if (Ng == vec3(0.0)) Ng = -ray.dir;
  cbvhSetHit(hit, ray, t, uv.x, uv.y, Ng, primID, name.geomID);
  nearest = CbvhVertNearest(true, ray.instID, t, name);
  return true;
}

/* True if something is hit nearer than hit.t, which is lowered. */
bool cbvhTraceVert (SceneData scene, CbvhPointer at, CbvhTravel ray, const bool anyHit, inout CbvhHit hit, inout CbvhVertNearest nearest)
{
  if (!cbvhIsSeen(scene, ray, at.geomID)) return false;
  CbvhVertBlock block = cbvhReadVertBlock(at, cbvhQuadword(at, 0u));
  CbvhVertRay vert;
  vert.shear = cbvhShear(ray.dir);
  vec3 size = abs(ray.dir);
  vert.largest = max(size.x, max(size.y, size.z));
  for (int k = 0; k < 3; k++) vert.rcp[k] = directionReciprocal(ray.dir[k], vert.largest);

  bool isRawBlock = isRaw(block.boxForm);
  float extent = float(maxExtent)*block.spacing;
  CbvhShearedRay sheared = CbvhShearedRay(0.0, 0.0, 0.0);
  CbvhCell first;
  first.word = first.data = 0u;
  first.c00 = first.c10 = first.c01 = first.c11 = ivec3(0);
  first.step = first.quadsX = first.quadsY = 1;
  if (!isRawBlock) {
    sheared = cbvhShearedRay(block, ray, vert, extent);
    if (!cbvhMeetsBlock(block, ray, vert, sheared, extent, hit.t)) return false;
    first = cbvhFirstCell(block);
  }

  /* groups that the ray meets: bit x + 4 y, mirrored so that the nearer ones tend to come first */
  vec3 alongX = vec3(first.c10 - first.c00), alongY = vec3(first.c01 - first.c00);
  uint mirror = (dot(alongX, ray.dir) < 0.0 ? 3u : 0u) | (dot(alongY, ray.dir) < 0.0 ? 12u : 0u);
  uint open = 0u;
  if (isRawBlock) {
    for (uint g = 0u; g < block.offsets.groups; g++)
      if (cbvhMeetsRawGroup(block, ray, vert, hit.t, g)) open |= 1u << ((g % block.offsets.groupsX + 4u*(g/block.offsets.groupsX)) ^ mirror);
  }
  else
  {
    vec3 below[5];
    CbvhRow firstRow = cbvhRow(first, 0);
    [[unroll]] for (int i = 0; i < 5; i++) below[i] = vec3(cbvhRowVertex(at, first, firstRow, i, 0));
    [[dont_unroll]] for (uint gy = 0u; gy < block.offsets.groupsY; gy++)
    {
      vec3 row[5];
      CbvhRow above = cbvhRow(first, int(gy) + 1);
      [[unroll]] for (int i = 0; i < 5; i++) row[i] = vec3(cbvhRowVertex(at, first, above, i, int(gy) + 1));
      [[unroll]] for (int i = 0; i < 4; i++)
        if (uint(i) < block.offsets.groupsX &&
            cbvhMeetsGroup(block, ray, vert, sheared, extent, hit.t, gy*block.offsets.groupsX + uint(i), below[i], below[i + 1], row[i], row[i + 1]))
          open |= 1u << ((uint(i) + 4u*gy) ^ mirror);
      [[unroll]] for (int i = 0; i < 5; i++) below[i] = row[i];
    }
  }

  bool found = false;
  while (open != 0u)
  {
    uint lane = uint(findLSB(open)) ^ mirror, gx = lane & 3u, gy = lane >> 2;
    open &= open - 1u;
    CbvhCell cell = first;
    if (!isRawBlock) {
      cell = cbvhGroupCell(block, first, gx, gy);
      if (found && !cbvhMeetsGroup(block, ray, vert, sheared, extent, hit.t, gy*block.offsets.groupsX + gx,
                                   vec3(cell.c00), vec3(cell.c10), vec3(cell.c01), vec3(cell.c11))) continue;
    }
    uint triangles = cbvhTriangles(block, cell, ray, vert.shear, gx, gy);
    while (triangles != 0u)
    {
      uint h = uint(findLSB(triangles));
      triangles &= triangles - 1u;
      if (!cbvhHitTriangle(block, cell, ray, vert.shear, gx, gy, h, hit, nearest)) continue;
      found = true;
      if (anyHit) return true;
    }
  }
  return found;
}

#endif
