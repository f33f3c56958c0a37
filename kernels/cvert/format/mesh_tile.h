// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A mesh tile: a mesh block (mesh_block.h) in another form, which at rest is about a third larger. Each group can be
 * read without the others, so that a ray decodes only the groups that it tests. Mesh tiles are made from blocks in
 * memory, with the very same triangles in the same order; files contain blocks. docs/formats/tile.md specifies
 * the form. Layout:
 *
 *   header | records of groups | offsets of groups | boxes of groups | groups | primitive numbers
 *
 * A group stores all vertices that its triangles use, including those that other groups also use, as the fields of
 * mesh blocks relative to its own box. It has six arrays. Each begins with a whole byte and has fields of the same
 * size: the first, second and third corners of its triangles, as indices of its vertices, and the coordinates of
 * its vertices on x, y and z.
 *
 * A moving mesh tile has a mesh tile at rest per time step, which begins at a multiple of 16 bytes:
 *
 *   header | VertMotion | offsets of steps | step 0 | step 1 | ...
 *
 * Its header has only surface, primID, meshBytes, counts, meshInfo, bytes and motion. No step has shear. Groups have
 * the same triangles and vertices at all steps; only step 0 stores corners and primitive numbers. */

#include "mesh_motion.h"
#include "tile.h"
#include <cstddef>

namespace cvert { inline namespace CVERT_ISA {
static const uint32_t meshTileHeaderBytes = 64;
static const uint32_t meshTileRecordBytes = 4;
static const uint32_t meshTileOffsetBytes = 2;
static const uint32_t maxTileGroupTriangles = 16; //!< blocks with larger groups do not become tiles
static const uint32_t maxTileFieldBits = 16;      //!< of a coordinate; blocks with longer ones do not become tiles
static const uint32_t meshTileReadPadding = 64;   //!< bytes after a mesh tile that decoders may read

/*! `origin` to `meshBytes` have the offsets of the block's members, so that code shared with blocks finds them. */
struct MeshTileHeader {
  float origin[3];
  uint32_t spacings;
  uint32_t surface;
  uint32_t primID;
  uint32_t meshBytes; //!< MeshHeader::bytes of the block
  uint32_t counts;    //!< MeshHeader::counts of the block, without version and kind
  uint32_t meshInfo;  //!< MeshHeader::info of the block, without version and kind
  float shear[3];     //!< factors of the axes in the sheared coordinate, in world space; 0 without shear
  uint32_t numbers;   //!< offset of the primitive numbers in bytes
  uint32_t bytes;     //!< of the tile, a multiple of 4
  uint32_t info;      //!< 0, where tiles of quads have tileInfo
  uint32_t motion;    //!< offset of VertMotion in bytes; 0 at rest
};
static_assert(sizeof(MeshTileHeader) == meshTileHeaderBytes, "header of a mesh tile");
static_assert(offsetof(MeshTileHeader, surface) == offsetof(MeshHeader, surface) &&
                  offsetof(MeshTileHeader, primID) == offsetof(MeshHeader, primID) &&
                  offsetof(MeshTileHeader, meshBytes) == offsetof(MeshHeader, bytes) &&
                  offsetof(MeshTileHeader, info) == offsetof(VertHeader, info),
              "a mesh tile must have members of other headers at the same offsets");

/*! Bit of MeshTileHeader::meshInfo: groups have no corners, as in steps after the first. */
static const uint32_t meshTileWithoutCorners = 1u << 14;

inline bool isMovingMeshTile(const MeshTileHeader* tile) { return tile->motion != 0; }

/*! Requires a tile that moves. */
inline VertMotion motionOfMeshTile(const MeshTileHeader* tile) {
  VertMotion motion;
  std::memcpy(&motion, (const uint8_t*)tile + tile->motion, sizeof(motion));
  return motion;
}

/*! Returns the tile of a time step. step: 0 unless the tile moves. */
inline const MeshTileHeader* meshTileOfStep(const MeshTileHeader* tile, uint32_t step) {
  if (!isMovingMeshTile(tile)) return tile;
  return (const MeshTileHeader*)((const uint8_t*)tile + wordAt(tile, motionOfMeshTile(tile).steps / 4 + step));
}

/* Record of a group:
 *
 *   bits 0..4            vertices
 *   bits 5..9            triangles, minus 1
 *   bits 10..14          bits of a primitive number; 31 means 32
 *   bits 15..19, 20..24, 25..29   bits of a coordinate on x, y and z */

inline uint32_t tileGroupVertices(uint32_t record) { return record & 31u; }
inline uint32_t tileGroupTriangles(uint32_t record) { return ((record >> 5) & 31u) + 1u; }
inline uint32_t tileGroupNumberBits(uint32_t record) {
  const uint32_t bits = (record >> 10) & 31u;
  return bits == 31u ? 32u : bits;
}
inline uint32_t tileGroupFieldBits(uint32_t record, uint32_t axis) { return (record >> (15u + 5u * axis)) & 31u; }

/*! Bits of a corner. */
inline uint32_t tileGroupCornerBits(uint32_t record) {
  return 32u - uint32_t(__builtin_clz((tileGroupVertices(record) - 1u) | 1u));
}

/*! Bytes of an array of fields. */
inline uint32_t bytesOfFields(uint32_t count, uint32_t bits) { return (count * bits + 7u) >> 3; }

/*! Bytes of an array of corners. meshInfo: of the tile. */
inline uint32_t bytesOfCorners(uint32_t meshInfo, uint32_t record) {
  return meshInfo & meshTileWithoutCorners ? 0 : bytesOfFields(tileGroupTriangles(record), tileGroupCornerBits(record));
}

/* Offsets in bytes. */
inline uint32_t meshTileRecord(uint32_t g) { return meshTileHeaderBytes + meshTileRecordBytes * g; }
inline uint32_t meshTileOffset(uint32_t groups, uint32_t g) { return meshTileRecord(groups) + meshTileOffsetBytes * g; }
/*! Array of a byte per group: lower planes on x, y and z, then upper ones. Planes are multiples of 2^meshBoxShift, and
 *  the upper plane is the one after the byte. */
inline uint32_t meshTilePlanes(uint32_t groups, uint32_t plane) {
  return meshTileOffset(groups, groups) + plane * groups;
}
inline uint32_t meshTileGroups(uint32_t groups) { return meshTilePlanes(groups, 6); }
}} // namespace cvert::CVERT_ISA
