// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Intersects a ray with a tile (kernels/cvert/format/tile.h), with the hits of its block: the boxes of all leaves, then
 * the triangles of one leaf at a time. Nothing is decoded but what is tested. */

#ifndef CBVH_TILE_GLSL
#define CBVH_TILE_GLSL

#include "vert_boxes.glsl"
#include "vert_triangle.glsl"
#include "../../cvert/format/tile.h"

struct CbvhTile {
  uvec2 at; // address
  uint geomID;
  uint region, info;
  uint bytes;         // per vertex
  uint row, vertices; // vertices in a row; offset of the first one, in bytes
  uint plane;         // stored vertices
  ivec3 slopeX, slopeY, base;
  uvec2 shift; // of residuals on y and z
  uvec3 mask;  // of residuals
  vec3 origin, spacing;
};

CbvhTile cbvhReadTile(CbvhPointer at) {
  CbvhTile tile;
  tile.at = at.address;
  tile.geomID = at.geomID;
  tile.region = CVERT_AT(VertHeader, tile.at).region;
  tile.info = CVERT_AT(VertHeader, tile.at).info;
  tile.bytes = tileVertexBytes(tile.at);
  tile.row = tileRowVertices(tile.region);
  tile.plane = tile.row * tileRows(tile.region);
  tile.vertices = tileVerticesOffset(tile.region, tile.info);
  int scale = tileScale(tile.at);
  for (int k = 0; k < 3; k++) {
    tile.slopeX[k] = tileInt16(tile.at, tileSlopeXOffset, k);
    tile.slopeY[k] = tileInt16(tile.at, tileSlopeYOffset, k);
    tile.base[k] = tileInt16(tile.at, tileBaseOffset, k) * scale;
    tile.mask[k] = (1u << tileBits(tile.at, k)) - 1u;
    tile.origin[k] = CVERT_AT(VertHeader, tile.at).origin[k];
    tile.spacing[k] = tileSpacing(tile.at, k);
  }
  tile.shift = uvec2(tileBits(tile.at, 0), tileBits(tile.at, 0) + tileBits(tile.at, 1));
  return tile;
}

/* --- vertices -------------------------------------------------------------------------- */

/* World position of vertex x, y. low, high: its packed residuals, see tileCoordinate. */
vec3 cbvhTileVertex(CbvhTile tile, uint low, uint high, uint x, uint y) {
  uint z = tile.shift.y < 32u ? low >> tile.shift.y : 0u;
  if (tile.bytes == maxTileVertexBytes) z |= high << (32u - tile.shift.y);
  uvec3 residual = uvec3(low, low >> tile.shift.x, z) & tile.mask;
  ivec3 coordinate = tile.base + int(x) * tile.slopeX + int(y) * tile.slopeY + ivec3(residual);
  precise vec3 at = tile.origin + vec3(coordinate) * tile.spacing;
  return at;
}

vec3 cbvhTileFloats(CbvhTile tile, uint vertex) {
  uint first = tile.vertices / 4u + vertex;
  return vec3(floatAt(tile.at, first), floatAt(tile.at, first + tile.plane), floatAt(tile.at, first + 2u * tile.plane));
}

/* Upper byte of a vertex of 5 bytes. */
uint cbvhTileHigh(CbvhTile tile, uint vertex) {
  return tile.bytes == maxTileVertexBytes ? byteAt(tile.at, tile.vertices + 4u * tile.plane + vertex) : 0u;
}

vec3 cbvhTileVertex(CbvhTile tile, uint x, uint y) {
  uint vertex = y * tile.row + x;
  if (tile.bytes == tileFloatBytes) return cbvhTileFloats(tile, vertex);
  uint bit = 8u * (tile.vertices + min(tile.bytes, 4u) * vertex);
  return cbvhTileVertex(tile, bitsAt(tile.at, bit, 32u), cbvhTileHigh(tile, vertex), x, y);
}

/* Vertices x to x + 4 of row y, sheared. x: of a leaf. */
void cbvhShearedRow(CbvhTile tile, CbvhPreparedRay ray, CbvhShear shear, uint x, uint y, out vec2 row[5]) {
  uint vertex = y * tile.row + x;
  if (tile.bytes == tileFloatBytes) {
    [[dont_unroll]] for (uint i = 0u; i < 5u; i++)
      row[i] = cbvhSheared(shear, ray.org, cbvhTileFloats(tile, vertex + i));
    return;
  }
  uint offset = tile.vertices + min(tile.bytes, 4u) * vertex, shift = 8u * (offset & 3u);
  uint words[5], packed[5];
  [[unroll]] for (uint i = 0u; i < 5u; i++)
    words[i] = wordAt(tile.at, (offset >> 2) + i);
  if (tile.bytes < 4u) {
    if (shift != 0u) [[unroll]]
      for (uint i = 0u; i < 4u; i++) words[i] = (words[i] >> shift) | (words[i + 1u] << (32u - shift));
    bool hasThree = tile.bytes == 3u;
    packed[0] = words[0];
    packed[1] = hasThree ? (words[0] >> 24) | (words[1] << 8) : words[0] >> 16;
    packed[2] = hasThree ? (words[1] >> 16) | (words[2] << 16) : words[1];
    packed[3] = hasThree ? words[2] >> 8 : words[1] >> 16;
    packed[4] = hasThree ? words[3] : words[2];
  } else packed = words;
  [[unroll]] for (uint i = 0u; i < 5u; i++)
    row[i] = cbvhSheared(shear, ray.org, cbvhTileVertex(tile, packed[i], cbvhTileHigh(tile, vertex + i), x + i, y));
}

/* --- boxes ----------------------------------------------------------------------------- */

/* A ray enters and leaves a box at near + byte * scale and far + byte * scale, by the bytes of its planes. */
struct CbvhTileRay {
  uvec2 boxes; // address
  vec3 scale, near, far;
  uvec3 isNegative; // 1 on axes along which the upper planes come first
  bool isSafe;      // no distance overflows
};

CbvhTileRay cbvhTileRay(CbvhTile tile, CbvhPreparedRay ray) {
  CbvhVertRay vert = cbvhVertRay(ray);
  CbvhTileRay to;
  to.boxes = bytesAfter(tile.at, tileBoxesOffset(tile.info));
  vec3 unit = vec3(tileBoxUnit(tile.at, 0), tileBoxUnit(tile.at, 1), tileBoxUnit(tile.at, 2));
  vec3 distance = tile.origin - ray.org, steps = tile.spacing * float(tileScale(tile.at));
  float largest = float((maxBoxByte + 1u) * maxBoxByte) * max(steps.x, max(steps.y, steps.z));
  vec3 slack = (tileSlackUlps * floatUlp) * (abs(distance) + largest) * abs(vert.rcp);
  vec3 offset = distance * vert.rcp;
  to.scale = unit * vert.rcp;
  to.near = offset - slack;
  to.far = offset + slack;
  to.isNegative = uvec3(lessThan(vert.rcp, vec3(0.0)));
  to.isSafe = all(lessThan(float(maxBoxByte + 1u) * abs(to.scale) + abs(offset) + slack, vec3(1e37)));
  return to;
}

vec4 cbvhBytes(uint word) { return vec4((uvec4(word) >> uvec4(0u, 8u, 16u, 24u)) & 255u); }

/* Mask of the leaves whose boxes the ray enters before tfar: bit column + 4 row. */
uint cbvhEnteredLeaves(CbvhTile tile, CbvhTileRay to, float tnear, float tfar) {
  uint leaves = 0u;
  if (!to.isSafe) return tileLeaves(tile.region);
  uint rows = leavesAlongY(vertQuadsY(tile.region));
  [[dont_unroll]] for (uint i = 0u; i < rows; i++) {
    uint first = 24u * (i >> 2) + (i & 3u);
    vec4 from = vec4(tnear), until = vec4(tfar);
    [[unroll]] for (uint k = 0u; k < 3u; k++) {
      uint plane = first + 8u * k, upper = 4u * to.isNegative[k];
      from = max(from, cbvhBytes(wordAt(to.boxes, plane + upper)) * to.scale[k] + to.near[k]);
      until = min(until, cbvhBytes(wordAt(to.boxes, plane + 4u - upper)) * to.scale[k] + to.far[k]);
    }
    uvec4 isHit = uvec4(lessThanEqual(from, until));
    leaves |= (isHit.x | (isHit.y << 1) | (isHit.z << 2) | (isHit.w << 3)) << (4u * i);
  }
  return leaves & tileLeaves(tile.region);
}

/* True if the ray enters a leaf's box before tfar. */
bool cbvhEntersLeaf(CbvhTile tile, CbvhTileRay to, uint leaf, float tfar) {
  bool enters = true;
  for (int k = 0; k < 3; k++)
    enters = enters && float(tilePlane(tile.at, leaf, k, to.isNegative[k])) * to.scale[k] + to.near[k] <= tfar;
  return enters || !to.isSafe;
}

/* Moves bit i of a mask to bit i ^ flip. flip: see leafFlip. */
uint cbvhFlippedLeaves(uint leaves, uint flip) {
  uint all = flip >= 28u ? bitfieldReverse(leaves) : leaves;
  if (flip == 0u || flip == 31u) return all;
  return ((all & 0x11111111u) << 3) | ((all & 0x22222222u) << 1) | ((all >> 1) & 0x22222222u) |
         ((all >> 3) & 0x11111111u);
}

/* --- triangles ------------------------------------------------------------------------- */

/* Mask of a leaf's triangles that the ray's line may pass through: bits 2q and 2q + 1 for quad q = i + 4j. */
uint cbvhLeafTriangles(CbvhTile tile, CbvhPreparedRay ray, CbvhShear shear, uint leaf) {
  uint mask = 0u, x = leafQuadsX * (leaf & 3u), y = leafQuadsY * (leaf >> 2);
  vec2 below[5] = vec2[5](vec2(0.0), vec2(0.0), vec2(0.0), vec2(0.0), vec2(0.0));
  [[dont_unroll]] for (uint j = 0u; j <= leafQuadsY; j++) {
    vec2 row[5];
    cbvhShearedRow(tile, ray, shear, x, y + j, row);
    if (j > 0u) mask |= cbvhRowTriangles(below, row) << (8u * (j - 1u));
    below = row;
  }
  return mask;
}

/* Tests a triangle of a leaf exactly. triangle: index of its bit in cbvhLeafTriangles. */
bool cbvhIntersectLeafTriangle(CbvhTile tile, CbvhPreparedRay ray, CbvhShear shear, uint leaf, uint triangle,
                               inout CbvhHit hit, inout CbvhVertNearest nearest) {
  uint x = leafQuadsX * (leaf & 3u) + quadXOfTriangle(triangle),
       y = leafQuadsY * (leaf >> 2) + quadYOfTriangle(triangle);
  vec3 vertices[3];
  [[dont_unroll]] for (int v = 0; v < 3; v++) {
    uint corner = cornerOfTriangle(triangle, v);
    vertices[v] = cbvhTileVertex(tile, x + (corner & 1u), y + (corner >> 1));
  }
  uint lane = (leaf & 3u) | ((leaf >> 3) << 2), index = triangle + ((leaf & 4u) << 2); // as in blocks
  return cbvhIntersectQuadTriangle(tile.at, tile.geomID, ray, shear, lane, index, vertices[0], vertices[1], vertices[2],
                                   tile.bytes == tileFloatBytes, hit, nearest);
}

/* Loops have one exit, see cbvhTraceGroup. */
bool cbvhTraceTile(SceneData scene, CbvhPointer at, CbvhPreparedRay ray, const bool anyHit, inout CbvhHit hit,
                   inout CbvhVertNearest nearest) {
  if (!cbvhIsVisible(scene, ray, at.geomID)) return false;
  CbvhTile tile = cbvhReadTile(at);
  CbvhTileRay to = cbvhTileRay(tile, ray);
  CbvhShear shear = cbvhShear(ray.dir);
  uint octant = to.isNegative.x | (to.isNegative.y << 1) | (to.isNegative.z << 2);
  uint flip = anyHit ? 0u : leafFlip(tile.at, octant);
  uint leaves = cbvhFlippedLeaves(cbvhEnteredLeaves(tile, to, ray.tnear, hit.t), flip);
  bool found = false;
  while (leaves != 0u) {
    uint leaf = uint(findLSB(leaves)) ^ flip;
    leaves &= leaves - 1u;
    if (found && !cbvhEntersLeaf(tile, to, leaf, hit.t)) continue;
    uint triangles = cbvhLeafTriangles(tile, ray, shear, leaf);
    while (triangles != 0u) {
      uint triangle = uint(findLSB(triangles));
      triangles &= triangles - 1u;
      if (!cbvhIntersectLeafTriangle(tile, ray, shear, leaf, triangle, hit, nearest)) continue;
      found = true;
      if (anyHit) triangles = leaves = 0u;
    }
  }
  return found;
}

#endif
