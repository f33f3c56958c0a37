// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A mesh block: up to 256 triangles of any mesh in up to 16 groups, with their vertices and primitive numbers, for
 * meshes without rows of quads. docs/formats/mesh.md specifies it. Layout:
 *
 *   header | records of groups | boxes of groups | topology of groups | fields of vertices | primitive numbers
 *
 * Only sizes of groups are stored: offsets in the last three sections are sums over the groups before.
 *
 * A vertex belongs to the first group that uses it; other groups refer to its index in the block. On each axis a
 * vertex is origin + coordinate * spacing, exact in float, with a power of two as spacing. If this needs too many bits,
 * or more than ranks, the coordinate is a rank, the number of floats from origin to vertex. Fields are coordinates
 * relative to the owning group's box. One axis may be sheared, so that inclined sheets have flat boxes and short
 * fields.
 *
 * A group's triangles are generalized strips: each triangle after the first uses the next vertex of a stream and two
 * vertices of the triangle before it, the last one, and the second to last or the first. Bit masks determine the
 * position of each triangle in the stream, so triangles are decoded in parallel.
 *
 * Based on: Deering, "Geometry Compression", 1995; Barczak, Benthin, McAllister, "DGF: A Dense, Hardware-Friendly
 * Geometry Format for Lossily Compressing Meshlets with Arbitrary Topologies", 2024. */

#ifndef CVERT_FORMAT_MESH_BLOCK_H
#define CVERT_FORMAT_MESH_BLOCK_H

#include "block.h"

CVERT_BEGIN

/*! Stored where grid blocks (block.h) store their version, so that their readers reject mesh blocks. */
CVERT_CONSTANT uint32_t meshFormatVersion = 6u;

/*! Kind of a block, in bits of `counts` and `info` that version 5 reserves. Grid blocks have kind 0. */
CVERT_CONSTANT uint32_t kindOfMesh = 1u;

CVERT_CONSTANT uint32_t meshHeaderBytes = 56u;
CVERT_CONSTANT uint32_t meshRecordBytes = 2u; //!< per group
CVERT_CONSTANT uint32_t meshBoxBytes = 6u;    //!< per group
CVERT_CONSTANT uint32_t maxMeshTriangles = 256u;
CVERT_CONSTANT uint32_t maxMeshGroups = 16u;
CVERT_CONSTANT uint32_t maxGroupTriangles = 32u;
CVERT_CONSTANT uint32_t maxGroupVertices = 31u;
CVERT_CONSTANT uint32_t maxGroupRestarts = 15u;
CVERT_CONSTANT uint32_t maxMeshVertices = 496u; //!< maxMeshGroups*maxGroupVertices
CVERT_CONSTANT uint32_t maxMeshCoordinateBits = 23u;
CVERT_CONSTANT uint32_t minRankShift = 9u; //!< smallest shift of boxes on an axis of ranks

struct MeshHeader {
  float origin[3]; //!< position of coordinates (0,0,0)
  //! bits 0..7, 8..15, 16..23: biased exponents on x, y, z, or 0 on an axis of ranks; other bits: 0
  uint32_t spacings;
  uint32_t surface; //!< see limits.h
  uint32_t primID;  //!< base of primitive numbers
  uint32_t bytes;   //!< of the block, a multiple of 4
  uint32_t motion;  //!< offset of VertMotion if the block moves (mesh_motion.h), else 0
  //! a byte per group, 0 if unused: bits 0..4: triangles minus 1; 5..7: lower bits of the number of restarts
  uint32_t groups[4];
  //! bits 0..9: vertices minus 1; 10..13: groups minus 1; 16..23: triangles minus 1; 24..29: bits of the base number of
  //! a group
  uint32_t counts;
  //! bits 0..11: shifts of boxes, a nibble per axis; 12..13: sheared axis; 16..20, 21..25: slopes; 26: the triangles
  //! are halves of quads; 27..29: 0
  uint32_t info;
};

CVERT_FUNCTION uint32_t meshVertices(uint32_t counts) { return (counts & 1023u) + 1u; }
CVERT_FUNCTION uint32_t meshGroups(uint32_t counts) { return ((counts >> 10) & 15u) + 1u; }
CVERT_FUNCTION uint32_t meshTriangles(uint32_t counts) { return ((counts >> 16) & 255u) + 1u; }
CVERT_FUNCTION uint32_t baseNumberBits(uint32_t counts) { return (counts >> 24) & 63u; }

/* Version and kind in `counts` and `info`, which are words 4 and 5 of corners in a grid block. */
CVERT_FUNCTION uint32_t meshTagOfCounts() {
  return (meshFormatVersion & 1u) << 15 | (meshFormatVersion & 2u) << 30 | (kindOfMesh & 1u) << 14 |
         (kindOfMesh & 2u) << 29;
}
CVERT_FUNCTION uint32_t meshTagOfInfo() {
  return (meshFormatVersion & 4u) << 13 | (meshFormatVersion & 8u) << 28 | (kindOfMesh & 4u) << 12 |
         (kindOfMesh & 8u) << 27;
}

/* Version and kind of any block, from its words 12 and 13. */
CVERT_FUNCTION uint32_t versionOfBlock(uint32_t counts, uint32_t info) { return versionOfCorners(counts, info); }
CVERT_FUNCTION uint32_t kindOfBlock(uint32_t counts, uint32_t info) { return reservedOfCorners(counts, info); }

CVERT_FUNCTION float meshSpacing(uint32_t spacings, uint32_t axis) {
  return floatOfBits(((spacings >> (8u * axis)) & 255u) << 23);
}

CVERT_FUNCTION bool hasRanks(uint32_t spacings, uint32_t axis) { return ((spacings >> (8u * axis)) & 255u) == 0u; }
CVERT_FUNCTION bool hasRanksOnAnyAxis(uint32_t spacings) {
  return hasRanks(spacings, 0u) || hasRanks(spacings, 1u) || hasRanks(spacings, 2u);
}

/*! Position of a float in the sequence of all floats. Neighboring floats differ by 1. 0 has rank 2^31. */
CVERT_FUNCTION uint32_t rankOfFloat(float x) {
  uint32_t bits = bitsOfFloat(x);
  return (bits >> 31) != 0u ? 0u - bits : bits + 0x80000000u;
}
CVERT_FUNCTION float floatOfRank(uint32_t rank) {
  return floatOfBits(rank >= 0x80000000u ? rank - 0x80000000u : 0u - rank);
}

/*! Planes of groups' boxes are multiples of 2^meshBoxShift coordinates. */
CVERT_FUNCTION uint32_t meshBoxShift(uint32_t spacings, uint32_t info, uint32_t axis) {
  return ((info >> (4u * axis)) & 15u) + (hasRanks(spacings, axis) ? minRankShift : 0u);
}

CVERT_FUNCTION uint32_t meshShearedAxis(uint32_t info) { return (info >> 12) & 3u; }

/*! Slope of axis m+i (i = 1 or 2), in 1/16. m: sheared axis. */
CVERT_FUNCTION int meshSlope(uint32_t info, uint32_t i) { return int(info << (16u - 5u * i)) >> 27; }

/*! Bit of `info`: the primitives are quads with two triangles, (v0,v1,v3) and (v2,v3,v1). A triangle's number is twice
 *  the number of its primitive, plus 1 for the second. */
CVERT_CONSTANT uint32_t meshHasQuads = 1u << 26;

/* number: of a triangle, see meshHasQuads. */
CVERT_FUNCTION uint32_t primitiveOfMesh(uint32_t info, uint32_t number) {
  return (info & meshHasQuads) != 0u ? number >> 1 : number;
}
CVERT_FUNCTION bool isSecondOfQuad(uint32_t info, uint32_t number) {
  return (info & meshHasQuads) != 0u && (number & 1u) != 0u;
}

/*! Amount that the shear adds to the coordinate on axis m. c1, c2: coordinates on the axes m+1 and m+2. Rounds to
 *  nearest, halves up. */
CVERT_FUNCTION int meshShear(uint32_t info, int c1, int c2) {
  return (meshSlope(info, 1u) * c1 + meshSlope(info, 2u) * c2 + 8) >> 4;
}

/* Accessors of a group's byte in MeshHeader::groups (`group`) and of its record (`record`). Bits of a record:
 *
 *   bits 0..4      vertices
 *   bits 5..9      vertices that belong to the group
 *   bits 10..14    bits of a primitive number; 31 means 32
 *   bit 15         upper bit of the number of restarts, which is the number of strips minus 1 */

CVERT_FUNCTION uint32_t groupTriangles(uint32_t group) { return (group & 31u) + 1u; }
CVERT_FUNCTION uint32_t groupRestarts(uint32_t group, uint32_t record) {
  return ((group >> 5) & 7u) | ((record >> 12) & 8u);
}
CVERT_FUNCTION uint32_t groupVertices(uint32_t record) { return record & 31u; }
CVERT_FUNCTION uint32_t groupOwnVertices(uint32_t record) { return (record >> 5) & 31u; }
CVERT_FUNCTION uint32_t groupNumberBits(uint32_t record) {
  uint32_t bits = (record >> 10) & 31u;
  return bits == 31u ? 32u : bits;
}

/*! Bits of an index below `count`. */
CVERT_FUNCTION uint32_t bitsForIndex(uint32_t count) {
  uint32_t bits = 0u;
  for (uint32_t rest = count - 1u; rest != 0u; rest >>= 1) bits++;
  return bits;
}

/*! Vertices in a group's stream: three for the first triangle of a strip, then one per triangle. */
CVERT_FUNCTION uint32_t streamLength(uint32_t triangles, uint32_t restarts) { return triangles + 2u + 2u * restarts; }

/* Topology of a group, in this order. Triangle 0 starts a strip, and the first three vertices of the stream are new.
 *
 *   restarts      a bit per triangle from 1 on: it starts a strip
 *   fans          a bit per triangle from 1 on: it keeps the first vertex of the triangle before it
 *   firstCorners  2 bits per triangle, 0 to 2: where the application's triangle begins, see stripTriangle
 *   newMask       a bit per vertex of the stream from 3 on: it is new and gets the next index in the group
 *   ownMask       a bit per vertex of the group: it belongs to the group
 *   repeats       for each vertex of the stream that is not new: its index in the group
 *   otherIndices  for each vertex of the group that does not belong to it: its index in the block */
struct MeshTopology {
  uint32_t restarts, fans, firstCorners, newMask, ownMask, repeats, otherIndices; //!< bit offsets in the topology
  uint32_t repeatBits, otherBits;                                                 //!< bits per entry
  uint32_t bits;                                                                  //!< of the whole topology
};

/*! group, record: see groupTriangles. vertices: of the block. */
CVERT_FUNCTION MeshTopology meshTopology(uint32_t group, uint32_t record, uint32_t vertices) {
  uint32_t triangles = groupTriangles(group), stream = streamLength(triangles, groupRestarts(group, record)),
           numVertices = groupVertices(record);
  MeshTopology at;
  at.repeatBits = bitsForIndex(numVertices);
  at.otherBits = bitsForIndex(vertices);
  at.restarts = 0u;
  at.fans = triangles - 1u;
  at.firstCorners = at.fans + triangles - 1u;
  at.newMask = at.firstCorners + 2u * triangles;
  at.ownMask = at.newMask + stream - 3u;
  at.repeats = at.ownMask + numVertices;
  at.otherIndices = at.repeats + (stream - numVertices) * at.repeatBits;
  at.bits = at.otherIndices + (numVertices - groupOwnVertices(record)) * at.otherBits;
  return at;
}

/*! Bits of a vertex's field on an axis. extent: of the group's box, as stored. */
CVERT_FUNCTION uint32_t meshFieldBits(uint32_t spacings, uint32_t info, uint32_t extent, uint32_t axis) {
  return bitsForIndex((extent + 1u) << meshBoxShift(spacings, info, axis)); // 2^32 wraps to 0, which has 32 bits
}

/*! Bits of a group's primitive numbers: a base, then a number per triangle. */
CVERT_FUNCTION uint32_t meshNumberBits(uint32_t counts, uint32_t group, uint32_t record) {
  return baseNumberBits(counts) + groupTriangles(group) * groupNumberBits(record);
}

/*! Offsets of sections, in bytes from the start of the block. */
struct MeshLayout {
  uint32_t records;
  uint32_t boxes; //!< six arrays of a byte per group: lower planes on x, y, z, then extents on x, y, z
  uint32_t topology;
};

CVERT_FUNCTION MeshLayout meshLayout(uint32_t counts) {
  uint32_t groups = meshGroups(counts);
  MeshLayout offsets;
  offsets.records = meshHeaderBytes;
  offsets.boxes = offsets.records + meshRecordBytes * groups;
  offsets.topology = offsets.boxes + meshBoxBytes * groups;
  return offsets;
}

/* Strips. Masks have a bit per triangle of the group. */

/*! Mask of bits 0 to t. */
CVERT_FUNCTION uint32_t bitsUpTo(uint32_t t) { return 0xFFFFFFFFu >> (31u - t); }

CVERT_FUNCTION uint32_t countBits(uint32_t mask) {
  uint32_t count = mask - ((mask >> 1) & 0x55555555u);
  count = (count & 0x33333333u) + ((count >> 2) & 0x33333333u);
  return (((count + (count >> 4)) & 0x0F0F0F0Fu) * 0x01010101u) >> 24;
}

/*! Position of the highest set bit. Requires a mask other than 0. */
CVERT_FUNCTION uint32_t highestBit(uint32_t mask) {
  uint32_t bit = 0u;
  for (uint32_t rest = mask >> 1; rest != 0u; rest >>= 1) bit++;
  return bit;
}

/*! Positions of a triangle's vertices in the stream, in the application's order. */
struct StripTriangle {
  uint32_t v0, v1, v2;
};

/*! Finds triangle t without decoding the triangles before it. Bit 0 must be set in restarts and clear in fans.
 *  firstCorner: of triangle t. */
CVERT_FUNCTION StripTriangle stripTriangle(uint32_t restarts, uint32_t fans, uint32_t firstCorner, uint32_t t) {
  uint32_t upTo = bitsUpTo(t);
  uint32_t last = t + 2u * countBits(restarts & upTo);
  uint32_t start = highestBit(restarts & upTo); // first triangle of the strip
  uint32_t lastUnfanned = highestBit((~fans | restarts) & upTo);
  uint32_t first = lastUnfanned + 2u * countBits(restarts & bitsUpTo(lastUnfanned)) - 2u;
  uint32_t flips = countBits(~(fans | restarts) & upTo & ~((1u << start) - 1u));
  uint32_t a = (flips & 1u) != 0u ? last - 1u : first, b = (flips & 1u) != 0u ? first : last - 1u;
  StripTriangle triangle;
  triangle.v0 = firstCorner == 0u ? a : firstCorner == 1u ? b : last;
  triangle.v1 = firstCorner == 0u ? b : firstCorner == 1u ? last : a;
  triangle.v2 = firstCorner == 0u ? last : firstCorner == 1u ? a : b;
  return triangle;
}

CVERT_END

#ifndef VULKAN
static_assert(sizeof(cvert::MeshHeader) == cvert::meshHeaderBytes, "header of a mesh block");

CVERT_BEGIN

/*! For blocks of any kind and version. Reads meshHeaderBytes bytes. */
inline bool isMeshBlock(const void* block) {
  uint32_t words[2];
  std::memcpy(words, (const uint8_t*)block + offsetof(MeshHeader, counts), sizeof(words));
  return kindOfBlock(words[0], words[1]) == kindOfMesh;
}

inline uint32_t meshGroupByte(const MeshHeader* block, uint32_t g) { return ((const uint8_t*)block->groups)[g]; }

inline uint32_t meshRecord(const MeshHeader* block, uint32_t g) {
  uint16_t record;
  std::memcpy(&record, (const uint8_t*)block + meshHeaderBytes + meshRecordBytes * g, sizeof(record));
  return record;
}

/*! plane: 0 to 2 for lower planes, 3 to 5 for extents. */
inline uint32_t meshPlane(const MeshHeader* block, uint32_t plane, uint32_t g) {
  return ((const uint8_t*)block)[meshLayout(block->counts).boxes + plane * meshGroups(block->counts) + g];
}

CVERT_END
#endif

#endif
