// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A ray through a block of cVERT: kernels/cbvh/vert/format.h and vertex_cell.h say what the
 * bytes are. Vertices are decoded a row at a time, and tested as they come; what a ray may hit is
 * then looked at again, exactly.
 *
 * No ray slips through, as vert/ray.h argues: the sides of edges are products of the same
 * numbers whichever triangle asks, which is why nothing here may be fused ("precise"), and those
 * that round to 0 count for both triangles until their exact sign is known. */

#ifndef CBVH_VERT_BLOCK_GLSL
#define CBVH_VERT_BLOCK_GLSL

#extension GL_EXT_shader_explicit_arithmetic_types_float64 : enable

#include "ray.glsl"
#include "../../cbvh/vert/format.h"

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

/* side of the ray on which an edge lies */
float cbvhSide (vec2 a, vec2 b)
{
  precise float p = a.x*b.y;
  precise float q = a.y*b.x;
  precise float side = p - q;
  return side;
}

/* --- vertices -------------------------------------------------------------------------- */

struct CbvhVertBlock
{
  CbvhPointer at;
  vec3 origin;
  uint reach;
  uint place, boxForm, word;
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
  block.place = cbvhWord(at, 6u);
  block.boxForm = cbvhWord(at, 14u);
  block.word = cbvhWord(at, 15u);
  block.offsets = vertLayout(block.place);
  block.quadsX = vertQuadsX(block.place);
  block.quadsY = vertQuadsY(block.place);
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

/* They only cull. By how many ulps they are widened: see vert/intersector1.h. */
const float CBVH_SLACK_ULPS = 8.0, CBVH_SHEARED_SLACK_ULPS = 16.0;

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
  CbvhShearedRay sheared;
  float dir = 0.0, sum = 0.0;
  sheared.org = 0.0;
  int m = shearedAxis(block.boxForm);
  for (int i = 2; i >= 0; i--) {
    int k = cbvhNextAxis(m, i);
    float slope = i == 0 ? 1.0 : float(shearSlope(block.boxForm, i))*(1.0/16.0);
    float along = ray.org[k] - block.origin[k];
    sheared.org += slope*along;
    dir += slope*ray.dir[k];
    sum += abs(slope)*(abs(along) + extent);
  }
  sheared.rcp = cbvhReciprocal(dir, vert.largest);
  sheared.error = CBVH_SHEARED_SLACK_ULPS*floatUlp*sum;
  return sheared;
}

void cbvhClip (inout float tNear, inout float tFar, float lower, float upper, float rcp)
{
  float a = lower*rcp, b = upper*rcp;
  tNear = max(tNear, min(a, b));
  tFar = min(tFar, max(a, b));
}

float cbvhSlack (CbvhVertBlock block, CbvhTravel ray, int k, float extent) {
  return CBVH_SLACK_ULPS*floatUlp*(abs(block.origin[k] - ray.org[k]) + extent);
}

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

bool cbvhIsInside (float a, float b, float c) { return min(a, min(b, c)) >= 0.0 || max(a, max(b, c)) <= 0.0; }
bool cbvhIsWithin (float a, float b, float c) { return min(a, min(b, c)) > 0.0 || max(a, max(b, c)) < 0.0; }

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
      if (cbvhIsInside(diag, left, bottom)) mask |= 1u << bit;
      if (cbvhIsInside(right, top, -diag)) mask |= 2u << bit;
    }
    [[unroll]] for (int i = 0; i < 5; i++) below[i] = row[i];
  }
  if (quadsX < 4) { // what is behind the last column has no area
    uint columns = (1u << (2*quadsX)) - 1u;
    mask &= columns*0x01010101u;
  }
  return mask;
}

#ifdef CBVH_FLOAT64

/* Whether the sheared triangle has the ray in it: products of floats are exact in double. */
bool cbvhContains (vec2 a, vec2 b, vec2 c)
{
  precise double s0 = double(b.x)*double(c.y) - double(b.y)*double(c.x);
  precise double s1 = double(c.x)*double(a.y) - double(c.y)*double(a.x);
  precise double s2 = double(a.x)*double(b.y) - double(a.y)*double(b.x);
  double least = min(s0, min(s1, s2)), greatest = max(s0, max(s1, s2));
  return least >= 0.0lf ? greatest > 0.0lf : greatest <= 0.0lf;
}

struct CbvhVertTriangle
{
  dvec3 normal;
  vec3 a, b, c;
};

CbvhVertTriangle cbvhVertTriangle (vec3 a, vec3 b, vec3 c)
{
  CbvhVertTriangle triangle;
  triangle.a = a;
  triangle.b = b;
  triangle.c = c;
  triangle.normal = cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a));
  return triangle;
}

/* where the ray is nearest to the longest edge */
double cbvhAlongLongestEdge (CbvhVertTriangle triangle, CbvhTravel ray)
{
  double best = -1.0lf, t = 0.0lf;
  dvec3 d = dvec3(ray.dir);
  for (int i = 0; i < 3; i++)
  {
    vec3 from = i == 0 ? triangle.a : i == 1 ? triangle.b : triangle.c, to = i == 0 ? triangle.b : i == 1 ? triangle.c : triangle.a;
    dvec3 e = dvec3(to) - dvec3(from), w = dvec3(from) - dvec3(ray.org);
    double ee = dot(e, e), dd = dot(d, d), de = dot(d, e), dw = dot(d, w), ew = dot(e, w);
    if (ee <= best) continue;
    best = ee;
    double det = dd*ee - de*de;
    double s = det > 0.0lf ? min(max((de*dw - dd*ew)/det, 0.0lf), 1.0lf) : 0.0lf;
    t = (dw + s*de)/dd;
  }
  return t;
}

/* below this the ray lies in the plane, as far as vertices of 24 bits can tell */
const double CBVH_MIN_COSINE = 1e-6lf;

/* Where a ray that goes through it meets its plane; false beyond tnear and tfar. */
bool cbvhMeetPlane (CbvhVertTriangle triangle, CbvhTravel ray, int kz, float tfar, out float t)
{
  dvec3 org = dvec3(ray.org), dir = dvec3(ray.dir), n = triangle.normal;
  double size = abs(n.x*dir.x) + abs(n.y*dir.y) + abs(n.z*dir.z);
  double height = dot(n, dvec3(triangle.a) - org), speed = dot(n, dir);
  dvec3 z = (dvec3(triangle.a[kz], triangle.b[kz], triangle.c[kz]) - org[kz])/dir[kz];
  double exact = height/speed;
  if (!(abs(speed) > CBVH_MIN_COSINE*size)) exact = cbvhAlongLongestEdge(triangle, ray);
  exact = min(max(exact, min(z.x, min(z.y, z.z))), max(z.x, max(z.y, z.z)));
  t = float(exact);
  return exact >= double(ray.tnear) && exact <= double(tfar);
}

vec3 cbvhNormal (CbvhVertTriangle triangle) { return vec3(triangle.normal); }

#else
#error cVERT needs 64-bit floats: define CBVH_FLOAT64, or leave CBVH_KIND_VERT out
#endif

/* what is not a number, of slivers, becomes the middle of the diagonal */
float cbvhInUnit (float x) { return x >= 0.0 ? min(x, 1.0) : x < 0.0 ? 0.0 : 0.5; }

/* Parameters of the face at position a, b of quad x, y of the patch. */
vec2 cbvhVertParameters (CbvhVertBlock block, uint rates, uint x, uint y, bool second, float a, float b)
{
  uint quadsX = patchQuadsX(rates), quadsY = patchQuadsY(rates);
  a = cbvhInUnit(a);
  b = cbvhInUnit(b);
  vec2 uv = vec2((float(x) + a)/float(quadsX), (float(y) + b)/float(quadsY));
  bool isStitched = vertRate(rates, 0) != vertRate(rates, 2) || vertRate(rates, 1) != vertRate(rates, 3);
  if (isStitched && (x == 0u || y == 0u || x + 1u == quadsX || y + 1u == quadsY))
  {
    /* barycentrics of 00, 10, 01, 11 */
    vec4 w = second ? vec4(0.0, 1.0 - b, 1.0 - a, a + b - 1.0) : vec4(1.0 - a - b, a, b, 0.0);
    uv = vec2(0.0);
    for (uint c = 0u; c < 4u; c++) {
      uint i = x + (c & 1u), j = y + (c >> 1);
      uv.x += w[c]*vertParameter(i, quadsX, j == 0u ? vertRate(rates, 0) : j == quadsY ? vertRate(rates, 2) : quadsX);
      uv.y += w[c]*vertParameter(j, quadsY, i == 0u ? vertRate(rates, 3) : i == quadsX ? vertRate(rates, 1) : quadsY);
    }
  }
  return 0.5*vec2(float(vertCornerU(block.place)), float(vertCornerV(block.place))) + max(uv, vec2(0.0));
}

/* Triangle h of a group, bits as of cbvhTriangles; true if it is hit. */
bool cbvhHitTriangle (CbvhVertBlock block, CbvhCell cell, CbvhTravel ray, CbvhShear shear, uint gx, uint gy, uint h, inout CbvhHit hit)
{
  int i = int((h >> 1) & 3u), j = int(h >> 3);
  bool second = (h & 1u) != 0u;
  vec3 a = cbvhGroupVertex(block, cell, gx, gy, i, second ? j + 1 : j);
  vec3 b = cbvhGroupVertex(block, cell, gx, gy, i + 1, j);
  vec3 c = cbvhGroupVertex(block, cell, gx, gy, second ? i + 1 : i, j + 1);
  if (isRaw(block.boxForm) && !(cbvhIsFinite(a) && cbvhIsFinite(b) && cbvhIsFinite(c))) return false;
  vec2 A = cbvhSheared(shear, ray.org, a), B = cbvhSheared(shear, ray.org, b), C = cbvhSheared(shear, ray.org, c);
  /* weights of a, b and c */
  float w0 = cbvhSide(B, C), w1 = cbvhSide(C, A), w2 = cbvhSide(A, B);
  if (!cbvhIsWithin(w0, w1, w2) && !cbvhContains(A, B, C)) return false;
  CbvhVertTriangle triangle = cbvhVertTriangle(a, b, c);
  float t;
  if (!cbvhMeetPlane(triangle, ray, shear.kz, hit.t, t)) return false;
  float sum = w0 + w1 + w2, b1 = w1/sum, b2 = w2/sum;
  uint x = vertX(block.place) + groupQuads*gx + uint(i), y = vertY(block.place) + groupQuads*gy + uint(j);
  vec2 uv = cbvhVertParameters(block, cbvhWord(block.at, 7u), x, y, second, second ? b1 + b2 : b1, second ? 1.0 - b1 : b2);
  vec3 Ng = cbvhNormal(triangle);
  if (Ng == vec3(0.0)) Ng = -ray.dir;
  cbvhSetHit(hit, ray, t, uv.x, uv.y, Ng, cbvhWord(block.at, 5u), cbvhWord(block.at, 4u));
  return true;
}

/* True if something is hit nearer than hit.t, which is lowered. */
bool cbvhTraceVert (SceneData scene, CbvhPointer at, CbvhTravel ray, const bool anyHit, inout CbvhHit hit)
{
  if (!cbvhIsSeen(scene, ray, cbvhWord(at, 4u))) return false;
  CbvhVertBlock block = cbvhReadVertBlock(at, cbvhQuadword(at, 0u));
  CbvhVertRay vert;
  vert.shear = cbvhShear(ray.dir);
  vec3 size = abs(ray.dir);
  vert.largest = max(size.x, max(size.y, size.z));
  for (int k = 0; k < 3; k++) vert.rcp[k] = cbvhReciprocal(ray.dir[k], vert.largest);

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
      if (!cbvhHitTriangle(block, cell, ray, vert.shear, gx, gy, h, hit)) continue;
      found = true;
      if (anyHit) return true;
    }
  }
  return found;
}

#endif
