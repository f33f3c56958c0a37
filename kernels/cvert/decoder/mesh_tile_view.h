// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decodes single vertices, corners and numbers of a mesh tile: the reference for the kernels' SIMD decoder. */

#include "../format/mesh_tile.h"
#include "mesh_view.h"

namespace cvert { inline namespace CVERT_ISA {
/*! tile: at rest, or a step of a moving one; of steps without corners only vertices and planes may be read. The tile
 * must outlive this object. */
class MeshTileView {
public:
  const MeshTileHeader* const tile;
  const uint32_t groups;

  explicit MeshTileView(const MeshTileHeader* tile) : tile(tile), groups(meshGroups(tile->counts)) {}

  uint32_t record(uint32_t g) const { return wordAt(tile, meshTileRecord(g) / 4); }
  uint32_t triangles(uint32_t g) const { return tileGroupTriangles(record(g)); }

  /*! Plane of a group's box as stored. plane: 0 to 2 for lower planes, 3 to 5 for upper ones. */
  uint32_t plane(uint32_t g, uint32_t plane) const { return byteAt(tile, meshTilePlanes(groups, plane) + g); }

  /*! Vertex of a group that is corner c of its triangle t. */
  uint32_t corner(uint32_t g, uint32_t t, uint32_t c) const {
    const uint32_t bits = tileGroupCornerBits(record(g));
    return field(offset(g) + c * bytesOfFields(triangles(g), bits), t, bits);
  }

  /*! World position of vertex v of a group. */
  void vertex(uint32_t g, uint32_t v, float out[3]) const {
    uint32_t coordinates[3], at = offset(g) + 3 * bytesOfCorners(tile->meshInfo, record(g));
    for (uint32_t k = 0; k < 3; k++) {
      const uint32_t bits = tileGroupFieldBits(record(g), k);
      coordinates[k] = (plane(g, k) << meshBoxShift(tile->spacings, tile->meshInfo, k)) + field(at, v, bits);
      at += bytesOfFields(tileGroupVertices(record(g)), bits);
    }
    const uint32_t m = meshShearedAxis(tile->meshInfo);
    coordinates[m] -= uint32_t(meshShear(tile->meshInfo, int(coordinates[(m + 1) % 3]), int(coordinates[(m + 2) % 3])));
    for (uint32_t k = 0; k < 3; k++)
      out[k] = tile->origin[k] + float(int(coordinates[k])) * meshSpacing(tile->spacings, k);
  }

  /*! Number of triangle t of group g, for primitiveOfMesh. */
  uint32_t number(uint32_t g, uint32_t t) const {
    uint32_t bit = 8 * tile->numbers;
    const uint32_t base = baseNumberBits(tile->counts);
    for (uint32_t i = 0; i < g; i++) bit += base + triangles(i) * tileGroupNumberBits(record(i));
    const uint32_t bits = tileGroupNumberBits(record(g));
    return tile->primID + meshBitsAt((const uint8_t*)tile, bit, base) +
           meshBitsAt((const uint8_t*)tile, bit + base + t * bits, bits);
  }

private:
  uint32_t offset(uint32_t g) const { return uint16At(tile, meshTileOffset(groups, g)); }

  uint32_t field(uint32_t offset, uint32_t i, uint32_t bits) const {
    return meshBitsAt((const uint8_t*)tile + offset, i * bits, bits);
  }
};
}} // namespace cvert::CVERT_ISA
