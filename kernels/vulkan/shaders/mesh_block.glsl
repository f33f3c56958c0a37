// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Intersects a ray with a mesh block (kernels/cvert/format/mesh_block.h): decodes the boxes of all groups. In groups
 * whose boxes the ray hits, nearest first, finds candidate triangles while it decodes vertices in the order of the
 * strips, then tests the candidates exactly. */

#ifndef CBVH_MESH_BLOCK_GLSL
#define CBVH_MESH_BLOCK_GLSL

#include "vert_boxes.glsl"
#include "vert_triangle.glsl"
#include "../../cvert/format/mesh_block.h"

CVERT_READABLE(MeshHeader, 16)

struct CbvhMeshBlock {
  uvec2 at; // address
  uint geomID;
  vec3 origin;
  uint spacings, primID, counts, info;
  uint groups;
  uint boxes;                                      // byte offset of the boxes
  uint topologyBegin, verticesBegin, numbersBegin; // first bits, from the start of the block
};

/* Per group: bit offsets in the block's sections, and the layout of its vertices' fields:
 *
 *   x   lower half: topology, upper half: fields of vertices
 *   y   lower half: numbers, upper half: index in the block of the first vertex that the group owns
 *   z   lower planes of its box on x, y and z, 8 bits each
 *   w   bits per field on x, y and z, 8 bits each */
uvec4 cbvhMeshGroups[maxMeshGroups];

/* Distances at which the ray enters the groups' boxes. */
float cbvhMeshEntries[maxMeshGroups];

/* Leaves verticesBegin and numbersBegin 0, which cbvhFindMeshGroups sets. */
CbvhMeshBlock cbvhReadMeshBlock(CbvhPointer at) {
  CbvhMeshBlock block;
  block.at = at.address;
  block.geomID = at.geomID;
  for (int k = 0; k < 3; k++) block.origin[k] = CVERT_AT(MeshHeader, block.at).origin[k];
  block.spacings = CVERT_AT(MeshHeader, block.at).spacings;
  block.primID = CVERT_AT(MeshHeader, block.at).primID;
  block.counts = CVERT_AT(MeshHeader, block.at).counts;
  block.info = CVERT_AT(MeshHeader, block.at).info;
  block.groups = meshGroups(block.counts);
  MeshLayout layout_ = meshLayout(block.counts);
  block.boxes = layout_.boxes;
  block.topologyBegin = 8u * layout_.topology;
  block.verticesBegin = block.numbersBegin = 0u;
  return block;
}

uint cbvhByteOf(uint word, int i) { return (word >> (8 * i)) & 255u; }

uint cbvhMeshGroupByte(CbvhMeshBlock block, uint g) {
  return cbvhByteOf(CVERT_AT(MeshHeader, block.at).groups[g >> 2], int(g & 3u));
}
uint cbvhMeshRecord(CbvhMeshBlock block, uint g) { return uint16At(block.at, meshHeaderBytes + meshRecordBytes * g); }

uint cbvhMeshBits(CbvhMeshBlock block, uint begin, uint count) {
  uint mask = count == 0u ? 0u : 0xFFFFFFFFu >> (32u - count);
  return bitsAt(block.at, begin, count) & mask;
}

/* World position of a coordinate on axis k. On the sheared axis it may be negative (modulo 2^32). */
float cbvhMeshPosition(CbvhMeshBlock block, int k, uint coordinate) {
  if (hasRanks(block.spacings, uint(k))) return floatOfRank(rankOfFloat(block.origin[k]) + coordinate);
  return block.origin[k] + float(int(coordinate)) * meshSpacing(block.spacings, uint(k));
}

bool cbvhIsMeshSheared(uint info) { return meshSlope(info, 1u) != 0 || meshSlope(info, 2u) != 0; }

/* --- boxes ------------------------------------------------------------------------------ */

/* Axes of a block's boxes, and the ray's sheared coordinate, relative to the block's origin. */
struct CbvhMeshAxes {
  int sheared;           // sheared axis; 3 if there is none
  bool isBounded;        // boxes clip rays on it, see cbvhMaxMeshRatio
  vec3 extent;           // bound of distances from the block's origin; 0 on an axis of ranks
  float org, rcp, error; // of the sheared ray; error: shearedSlack
};

/* Exponent of the largest ratio of spacings for which the sheared coordinate clips rays. */
const int cbvhMaxMeshRatio = 30;

CbvhMeshAxes cbvhMeshAxes(CbvhMeshBlock block, CbvhPreparedRay ray, CbvhVertRay vert) {
  CbvhMeshAxes axes = CbvhMeshAxes(3, true, vec3(0.0), 0.0, 1.0, 0.0);
  vec3 limit; // upper bounds of coordinates; planes have 8 bits
  for (int k = 0; k < 3; k++) {
    limit[k] = float(256u << meshBoxShift(block.spacings, block.info, uint(k)));
    axes.extent[k] = limit[k] * meshSpacing(block.spacings, uint(k));
  }
  if (!cbvhIsMeshSheared(block.info)) return axes;
  int m = int(meshShearedAxis(block.info)), exponent = int(cbvhByteOf(block.spacings, m));
  float sheared = limit[m] + 1.0;
  vec3 shears = vec3(0.0);
  shears[m] = 1.0;
  for (int i = 1; i < 3; i++) {
    int k = axisAfter(m, i), ratio = exponent - int(cbvhByteOf(block.spacings, k));
    float slope = float(meshSlope(block.info, uint(i))) * (1.0 / 16.0);
    axes.isBounded = axes.isBounded && abs(ratio) <= cbvhMaxMeshRatio;
    shears[k] = slope * floatOfBits(uint(clamp(ratio, -cbvhMaxMeshRatio, cbvhMaxMeshRatio) + 127) << 23);
    sheared += abs(slope) * limit[k];
  }
  axes.sheared = m;
  axes.extent[m] = sheared * meshSpacing(block.spacings, uint(m));
  ShearedCoordinate along = zeroShearedCoordinate();
  for (int k = 0; k < 3; k++)
    along = addSheared(along, ray.org[k], ray.dir[k], block.origin[k], axes.extent[k], shears[k]);
  axes.org = along.org;
  axes.rcp = directionReciprocal(along.dir, vert.largest);
  axes.error = shearedSlack(along.size);
  return axes;
}

/* Clips the ray by a group's box on axis k. plane, extent: as stored. */
RayInterval cbvhClippedByMeshPlanes(RayInterval interval, CbvhMeshBlock block, CbvhPreparedRay ray, CbvhVertRay vert,
                                    CbvhMeshAxes axes, uint plane, uint extent, int k) {
  uint shift = meshBoxShift(block.spacings, block.info, uint(k)), begin = plane << shift;
  uint end = (plane + extent + 1u) << shift;
  bool isSheared = k == axes.sheared;
  if (isSheared && !axes.isBounded) return interval;
  BoxPlanes planes;
  float from = ray.org[k], size = axes.extent[k];
  if (hasRanks(block.spacings, uint(k))) {
    planes = BoxPlanes(cbvhMeshPosition(block, k, begin), cbvhMeshPosition(block, k, end - 1u));
    size = planes.upper - block.origin[k];
  } else {
    float spacing = meshSpacing(block.spacings, uint(k)), origin = isSheared ? 0.0 : block.origin[k];
    // -0.5: sheared coordinates were rounded
    planes.lower = origin + (float(begin) - (isSheared ? 0.5 : 0.0)) * spacing;
    planes.upper = origin + float(end) * spacing;
  }
  if (isSheared) from = axes.org;
  float wide = isSheared ? axes.error : boxSlack(ray.org[k], block.origin[k], size);
  return clipInterval(interval, (planes.lower - from) - wide, (planes.upper - from) + wide,
                      isSheared ? axes.rcp : vert.rcp[k]);
}

/* Returns a mask of the groups whose boxes the ray hits. Sets verticesBegin, numbersBegin, cbvhMeshGroups and
 * cbvhMeshEntries. */
uint cbvhFindMeshGroups(inout CbvhMeshBlock block, CbvhPreparedRay ray, float tfar) {
  CbvhVertRay vert = cbvhVertRay(ray);
  CbvhMeshAxes axes = cbvhMeshAxes(block, ray, vert);
  uint groups = 0u, topology = 0u, vertices = 0u, numbers = 0u, firstVertex = 0u;
  [[dont_unroll]] for (uint g = 0u; g < block.groups; g++) {
    uint group = cbvhMeshGroupByte(block, g), record = cbvhMeshRecord(block, g);
    uint planes = 0u, fields = 0u, bits = 0u;
    RayInterval interval = RayInterval(ray.tnear, tfar);
    [[dont_unroll]] for (int k = 0; k < 3; k++) {
      uint plane = byteAt(block.at, block.boxes + uint(k) * block.groups + g);
      uint extent = byteAt(block.at, block.boxes + uint(k + 3) * block.groups + g);
      /* equals meshFieldBits, without its loop */
      uint field = uint(findMSB(extent) + 1) + meshBoxShift(block.spacings, block.info, uint(k));
      planes |= plane << (8 * k);
      fields |= field << (8 * k);
      bits += field;
      interval = cbvhClippedByMeshPlanes(interval, block, ray, vert, axes, plane, extent, k);
    }
    cbvhMeshGroups[g] = uvec4(topology | (vertices << 16), numbers | (firstVertex << 16), planes, fields);
    cbvhMeshEntries[g] = interval.from;
    if (interval.from <= interval.to) groups |= 1u << g;
    topology += meshTopology(group, record, meshVertices(block.counts)).bits;
    vertices += groupOwnVertices(record) * bits;
    numbers += meshNumberBits(block.counts, group, record);
    firstVertex += groupOwnVertices(record);
  }
  block.verticesBegin = block.topologyBegin + ((topology + 7u) & ~7u);
  block.numbersBegin = block.verticesBegin + ((vertices + 7u) & ~7u);
  return groups;
}

/* --- topology and vertices -------------------------------------------------------------- */

/* Topology of a group, see MeshTopology. */
struct CbvhMeshGroup {
  uint g;
  uint stream;                              // number of entries
  uint restarts, fans;                      // masks of triangles
  uvec2 newMask;                            // mask of entries
  uint ownMask;                             // mask of vertices
  uint firstCorners, repeats, otherIndices; // first bits, from the start of the block
  uint repeatBits, otherBits;
};

/* Requires cbvhFindMeshGroups. */
CbvhMeshGroup cbvhMeshGroup(CbvhMeshBlock block, uint g) {
  uint bits = cbvhMeshGroupByte(block, g), record = cbvhMeshRecord(block, g);
  uint first = block.topologyBegin + (cbvhMeshGroups[g].x & 65535u), triangles = groupTriangles(bits);
  MeshTopology topology = meshTopology(bits, record, meshVertices(block.counts));
  CbvhMeshGroup group;
  group.g = g;
  group.stream = streamLength(triangles, groupRestarts(bits, record));
  group.restarts = (cbvhMeshBits(block, first + topology.restarts, triangles - 1u) << 1) | 1u;
  group.fans = cbvhMeshBits(block, first + topology.fans, triangles - 1u) << 1;
  uint low = min(group.stream - 3u, 29u);
  group.newMask.x = (cbvhMeshBits(block, first + topology.newMask, low) << 3) | 7u;
  group.newMask.y = cbvhMeshBits(block, first + topology.newMask + low, group.stream - 3u - low);
  group.ownMask = cbvhMeshBits(block, first + topology.ownMask, groupVertices(record));
  group.firstCorners = first + topology.firstCorners;
  group.repeats = first + topology.repeats;
  group.otherIndices = first + topology.otherIndices;
  group.repeatBits = topology.repeatBits;
  group.otherBits = topology.otherBits;
  return group;
}

/* i: at most 31. */
uint cbvhBitsBelow(uint mask, uint i) { return uint(bitCount(mask & ((1u << i) - 1u))); }

/* Decodes the vertex at position i of the group's stream. */
vec3 cbvhStreamVertex(CbvhMeshBlock block, CbvhMeshGroup group, uint i) {
  bool isLow = i < 32u;
  uint newMask = isLow ? group.newMask.x : group.newMask.y;
  // new entries before i
  uint before = cbvhBitsBelow(newMask, i & 31u) + (isLow ? 0u : uint(bitCount(group.newMask.x)));
  uint vertex = before; // index of the vertex in the group
  if (((newMask >> (i & 31u)) & 1u) == 0u)
    vertex = cbvhMeshBits(block, group.repeats + (i - before) * group.repeatBits, group.repeatBits);

  uint owner = group.g, number = cbvhBitsBelow(group.ownMask, vertex); // index among the owner's vertices
  if (((group.ownMask >> vertex) & 1u) == 0u) {
    number = cbvhMeshBits(block, group.otherIndices + (vertex - number) * group.otherBits, group.otherBits);
    while (owner > 0u && number < cbvhMeshGroups[owner].y >> 16) owner--;
    number -= cbvhMeshGroups[owner].y >> 16;
  }
  uvec4 place = cbvhMeshGroups[owner];
  uint bits = cbvhByteOf(place.w, 0) + cbvhByteOf(place.w, 1) + cbvhByteOf(place.w, 2);
  uint bit = block.verticesBegin + (place.x >> 16) + number * bits;
  uint coordinates[3];
  for (int k = 0; k < 3; k++) {
    uint field = cbvhByteOf(place.w, k);
    coordinates[k] =
        cbvhMeshBits(block, bit, field) + (cbvhByteOf(place.z, k) << meshBoxShift(block.spacings, block.info, uint(k)));
    bit += field;
  }
  if (cbvhIsMeshSheared(block.info)) {
    int m = int(meshShearedAxis(block.info));
    coordinates[m] -= uint(meshShear(block.info, int(coordinates[axisAfter(m, 1)]), int(coordinates[axisAfter(m, 2)])));
  }
  vec3 at;
  for (int k = 0; k < 3; k++) at[k] = cbvhMeshPosition(block, k, coordinates[k]);
  return at;
}

/* --- triangles -------------------------------------------------------------------------- */

/* Returns a mask of the triangles that the ray's line may pass through, from either side. */
uint cbvhCandidateMeshTriangles(CbvhMeshBlock block, CbvhMeshGroup group, CbvhPreparedRay ray, CbvhShear shear) {
  uint mask = 0u, t = 0u;
  uint missing = 3u; // entries until triangle t is complete
  vec2 a = vec2(0.0), b = vec2(0.0), c = vec2(0.0);
  [[dont_unroll]] for (uint i = 0u; i < group.stream; i++) {
    if (((group.fans >> t) & 1u) == 0u) a = b;
    b = c;
    c = cbvhSheared(shear, ray.org, cbvhStreamVertex(block, group, i));
    missing--;
    if (missing == 0u) {
      if (mayContain(cbvhEdgeSide(b, c), cbvhEdgeSide(c, a), cbvhEdgeSide(a, b))) mask |= 1u << t;
      t++;
      missing = ((group.restarts >> (t & 31u)) & 1u) != 0u ? 3u : 1u;
    }
  }
  return mask;
}

/* Number of triangle t of group g, for primitiveOfMesh. */
uint cbvhMeshNumber(CbvhMeshBlock block, uint g, uint t) {
  uint baseBits = baseNumberBits(block.counts), bits = groupNumberBits(cbvhMeshRecord(block, g));
  uint first = block.numbersBegin + (cbvhMeshGroups[g].y & 65535u);
  return block.primID + cbvhMeshBits(block, first, baseBits) + cbvhMeshBits(block, first + baseBits + t * bits, bits);
}

/* Tests triangle t exactly. */
bool cbvhIntersectMeshTriangle(CbvhMeshBlock block, CbvhMeshGroup group, CbvhPreparedRay ray, CbvhShear shear, uint t,
                               inout CbvhHit hit, inout CbvhVertNearest nearest) {
  StripTriangle entries =
      stripTriangle(group.restarts, group.fans, cbvhMeshBits(block, group.firstCorners + 2u * t, 2u), t);
  vec3 a = vec3(0.0), b = vec3(0.0), c = vec3(0.0);
  [[dont_unroll]] for (int i = 0; i < 3; i++) {
    a = b;
    b = c;
    c = cbvhStreamVertex(block, group, i == 0 ? entries.v0 : i == 1 ? entries.v1 : entries.v2);
  }
  TriangleKey key = TriangleKey(block.geomID, block.primID, CVERT_AT(MeshHeader, block.at).bytes, 32u * group.g + t);
  CbvhVertHit at;
  if (!cbvhIntersectTriangle(ray, shear, a, b, c, key, hit.t, nearest, at)) return false;
  uint number = cbvhMeshNumber(block, group.g, t);
  float u = clampParameter(at.sides.w1 / at.sides.sum), v = clampParameter(at.sides.w2 / at.sides.sum);
  if (isSecondOfQuad(block.info, number)) {
    u = 1.0 - u;
    v = 1.0 - v;
  }
  cbvhSetHit(hit, ray, at.t, u, v, at.Ng, primitiveOfMesh(block.info, number), block.geomID);
  return true;
}

/* Returns the group whose box the ray enters first. groups: mask, not 0. */
uint cbvhFirstMeshGroup(uint groups) {
  uint first = uint(findLSB(groups));
  for (uint rest = groups & (groups - 1u); rest != 0u; rest &= rest - 1u) {
    uint g = uint(findLSB(rest));
    if (cbvhMeshEntries[g] < cbvhMeshEntries[first]) first = g;
  }
  return first;
}

/* Loops have one exit, see cbvhTraceGroup. */
bool cbvhTraceMesh(SceneData scene, CbvhPointer at, CbvhPreparedRay ray, const bool anyHit, inout CbvhHit hit,
                   inout CbvhVertNearest nearest) {
  if (!cbvhIsVisible(scene, ray, at.geomID)) return false;
  CbvhMeshBlock block = cbvhReadMeshBlock(at);
  CbvhShear shear = cbvhShear(ray.dir);
  uint groups = cbvhFindMeshGroups(block, ray, hit.t);
  bool found = false;
  while (groups != 0u) {
    uint g = cbvhFirstMeshGroup(groups);
    groups &= ~(1u << g);
    if (cbvhMeshEntries[g] <= hit.t) {
      CbvhMeshGroup group = cbvhMeshGroup(block, g);
      uint triangles = cbvhCandidateMeshTriangles(block, group, ray, shear);
      while (triangles != 0u) {
        uint t = uint(findLSB(triangles));
        triangles &= triangles - 1u;
        if (cbvhIntersectMeshTriangle(block, group, ray, shear, t, hit, nearest)) {
          found = true;
          if (anyHit) triangles = groups = 0u;
        }
      }
    } else groups = 0u; // the other groups are farther
  }
  return found;
}

#endif
