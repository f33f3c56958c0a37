// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts mesh blocks to mesh tiles (format/mesh_tile.h) and back, with the same triangles, vertices and numbers. */

#include "../decoder/decoded_mesh.h"
#include "../decoder/mesh_tile_view.h"
#include "../encoder/mesh_encoder.h"

namespace cvert { inline namespace CVERT_ISA {
/*! Upper bound of the bytes that tileOfMesh() writes: header and boxes, six arrays per group, numbers, padding. */
static const size_t maxBytesOfMeshTile =
    meshTileHeaderBytes + 12 * maxMeshGroups +
    maxMeshGroups * 3 * (maxTileGroupTriangles * 5 / 8 + maxGroupVertices * maxTileFieldBits / 8) + 1088 + 8;

/*! Factors of the world axes in the sheared coordinate; 0 without shear. Returns false if they are too far apart for
 *  boxes. */
inline bool worldShearOfMesh(uint32_t spacings, uint32_t info, float shear[3]) {
  for (int k = 0; k < 3; k++) shear[k] = 0.0f;
  if ((meshSlope(info, 1) | meshSlope(info, 2)) == 0) return true;
  const int m = int(meshShearedAxis(info));
  shear[m] = 1.0f;
  for (uint32_t i = 1; i < 3; i++) {
    const uint32_t k = (uint32_t(m) + i) % 3;
    const int ratio = int((spacings >> (8 * m)) & 255) - int((spacings >> (8 * k)) & 255);
    if (ratio < -30 || ratio > 30) return false;
    shear[k] = float(meshSlope(info, i)) * (1.0f / 16.0f) * floatOfBits(uint32_t(ratio + 127) << 23);
  }
  return true;
}

/*! Makes a stored coordinate of a vertex of group g relative to the group's box. Returns false if it lies outside of
 * the box, as in damaged files, or has more than `bits` bits. */
inline bool toFieldOfTile(const MeshHeader* block, uint32_t bits, uint32_t g, uint32_t axis, uint32_t& coordinate) {
  const uint32_t shift = meshBoxShift(block->spacings, block->info, axis), lower = meshPlane(block, axis, g),
                 upper = lower + meshPlane(block, 3 + axis, g);
  if (upper > 255 || coordinate >> shift < lower || coordinate >> shift > upper) return false;
  coordinate -= lower << shift;
  return coordinate >> bits == 0;
}

/*! Writes the tile of a valid mesh block at rest. tile: maxBytesOfMeshTile, aligned to 4. Returns its size, or 0 if
 *  the block has no tile: on an axis of ranks, with large groups or fields, or with a vertex outside of its box. */
inline size_t tileOfMesh(const MeshHeader* block, uint8_t* tile) {
  const MeshView view(block);
  MeshTileHeader& header = *(MeshTileHeader*)tile;
  if (hasRanksOnAnyAxis(block->spacings)) return 0;
  for (uint32_t g = 0; g < view.groups; g++) {
    if (groupTriangles(meshGroupByte(block, g)) > maxTileGroupTriangles) return 0;
    for (uint32_t bits : view.fieldBits[g])
      if (bits > maxTileFieldBits) return 0;
  }
  std::memset(tile, 0, meshTileHeaderBytes);
  if (!worldShearOfMesh(block->spacings, block->info, header.shear)) return 0;
  std::memcpy(tile, block, offsetof(MeshTileHeader, counts));
  header.counts = block->counts & 0x3FFF3FFFu;
  header.meshInfo = block->info & 0x3FFF3FFFu;
  uint8_t* at = tile + meshTileGroups(view.groups);
  for (uint32_t g = 0; g < view.groups; g++) {
    const DecodedMeshGroup group(view, g);
    uint32_t record =
        group.numVertices | (group.numTriangles - 1) << 5 | std::min(groupNumberBits(meshRecord(block, g)), 31u) << 10;
    for (uint32_t k = 0; k < 3; k++) {
      record |= view.fieldBits[g][k] << (15 + 5 * k);
      tile[meshTilePlanes(view.groups, k) + g] = uint8_t(meshPlane(block, k, g));
      tile[meshTilePlanes(view.groups, 3 + k) + g] = uint8_t(meshPlane(block, k, g) + meshPlane(block, 3 + k, g));
    }
    const uint16_t offset = uint16_t(at - tile);
    std::memcpy(tile + meshTileRecord(g), &record, sizeof(record));
    std::memcpy(tile + meshTileOffset(view.groups, g), &offset, sizeof(offset));
    for (uint32_t c = 0; c < 3; c++) {
      BitWriter corners(at);
      for (uint32_t t = 0; t < group.numTriangles; t++) corners.write(group.indices[c][t], tileGroupCornerBits(record));
      at = corners.finish();
    }
    uint32_t fields[maxGroupVertices][3];
    for (uint32_t i = 0; i < group.numVertices; i++) {
      view.storedCoordinates(group.vertices[i], fields[i]);
      for (uint32_t k = 0; k < 3; k++)
        if (!toFieldOfTile(block, view.fieldBits[g][k], g, k, fields[i][k])) return 0;
    }
    for (uint32_t k = 0; k < 3; k++) {
      BitWriter axis(at);
      for (uint32_t i = 0; i < group.numVertices; i++) axis.write(fields[i][k], view.fieldBits[g][k]);
      at = axis.finish();
    }
  }
  header.numbers = uint32_t(at - tile);
  const uint32_t numberBytes = (view.numberBegin[view.groups] + 7) / 8;
  std::memcpy(at, view.numbers, numberBytes);
  at += numberBytes;
  while ((at - tile) % 4 != 0) *at++ = 0;
  header.bytes = uint32_t(at - tile);
  return header.bytes;
}

/*! Writes the block of a mesh tile. block: MeshEncoder::maxBytes, aligned to 4. Returns its size. */
inline size_t meshOfTile(const MeshTileHeader* tile, MeshEncoder& encoder, uint8_t* block) {
  const MeshTileView view(tile);
  MeshTriangle triangles[maxMeshTriangles];
  MeshGroups groups;
  uint32_t count = 0;
  for (uint32_t g = 0; g < view.groups; g++) {
    for (uint32_t t = 0; t < view.triangles(g); t++, count++) {
      for (uint32_t c = 0; c < 3; c++) view.vertex(g, view.corner(g, t, c), triangles[count].corners[c]);
      triangles[count].number = view.number(g, t);
    }
    groups.add(count);
  }
  MeshStatistics statistics;
  const size_t bytes = encoder.encodeInOrder(triangles, groups, tile->surface, block, statistics);
  ((MeshHeader*)block)->info |= tile->meshInfo & meshHasQuads;
  return bytes;
}
}} // namespace cvert::CVERT_ISA
