// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Access to a mesh tile (cvert/format/mesh_tile.h) with vector instructions, without a cache: vertices and corners of a
 * group. Vertices are the same floats as MeshTileView::vertex() (cvert/decoder/mesh_tile_view.h) returns. */

#include "../base/codec_names.h"
#include "../../cvert/format/mesh_tile.h"
#include "packed_fields.h"
#include "mesh_corners.h"

namespace embree::isa::cbvh {
using namespace embree::cbvh;

/*! A group of a mesh tile. */
struct MeshTileGroup {
  const uint8_t* corners[3]; //!< arrays of fields of cornerBits
  const uint8_t* fields[3];  //!< arrays of fields of fieldBits, by axis
  uint32_t cornerBits, fieldBits[3];
  uint32_t numVertices, numTriangles;
  int lower[3]; //!< coordinates that fields are relative to, by axis

  /*! Vertex that is a corner of a triangle. */
  __forceinline uint8_t corner(uint32_t triangle, uint32_t c) const {
    const uint32_t bit = triangle * cornerBits;
    uint16_t word;
    memcpy(&word, corners[c] + (bit >> 3), sizeof(word));
    return uint8_t((word >> (bit & 7u)) & ((1u << cornerBits) - 1u));
  }
};

class MeshTileBlock {
public:
  typedef MeshTileGroup Group;

  __forceinline explicit MeshTileBlock(const MeshTileHeader* tile)
    : tile(tile),
      groups(meshGroups(tile->counts)),
      isSheared((tile->meshInfo & 0x03FF0000u) != 0) {
    for (int k = 0; k < 3; k++) spacing[k] = meshSpacing(tile->spacings, uint32_t(k));
    if (unlikely(isSheared)) {
      const int m = int(meshShearedAxis(tile->meshInfo));
      slope[m] = 0;
      slope[axisAfter(m, 1)] = meshSlope(tile->meshInfo, 1);
      slope[axisAfter(m, 2)] = meshSlope(tile->meshInfo, 2);
    }
  }

  __forceinline MeshTileGroup group(uint32_t g) const {
    const uint8_t* const bytes = (const uint8_t*)tile;
    const uint32_t record = wordAt(tile, meshTileRecord(g) / 4);
    MeshTileGroup at;
    at.numVertices = tileGroupVertices(record);
    at.numTriangles = tileGroupTriangles(record);
    at.cornerBits = tileGroupCornerBits(record);
    const uint8_t* array = bytes + uint16At(tile, meshTileOffset(groups, g));
    const uint32_t cornerBytes = bytesOfCorners(tile->meshInfo, record);
    for (int c = 0; c < 3; c++, array += cornerBytes) at.corners[c] = array;
    for (uint32_t k = 0; k < 3; k++) {
      at.fieldBits[k] = tileGroupFieldBits(record, k);
      at.fields[k] = array;
      array += bytesOfFields(at.numVertices, at.fieldBits[k]);
      at.lower[k] = int(uint32_t(bytes[meshTilePlanes(groups, k) + g]) << ((tile->meshInfo >> (4 * k)) & 15u));
    }
    return at;
  }

  /*! See pointOfMesh. */
  __forceinline uint32_t info() const { return tile->meshInfo; }

  /*! Sets out[i] to the vertices of a group on axis axes[i], in world space. vectors: that contain all vertices. */
  template<int vectors>
  __forceinline void vertices(const MeshTileGroup& group, const int axes[3], vfloatV (&out)[3][vectors]) const {
    vintV at[3][vectors];
    for (int i = 0; i < 3; i++) {
      const int k = axes[i];
      const vintV mask(int((1u << group.fieldBits[k]) - 1u)), lower(group.lower[k]);
      for (int j = 0; j < vectors; j++)
        at[i][j] = lower + (loadPackedFields(group.fields[k], group.fieldBits[k], uint32_t(vectorWidth * j)) & mask);
    }
    if (unlikely(isSheared)) unshear(axes, at);
    for (int i = 0; i < 3; i++) {
      const vfloatV scale(spacing[axes[i]]), origin(tile->origin[axes[i]]);
      for (int j = 0; j < vectors; j++) out[i][j] = madd(vfloatV(at[i][j]), scale, origin);
    }
  }

  /*! Number of a triangle, for primitiveOfMesh. */
  __forceinline uint32_t number(uint32_t g, uint32_t triangle) const {
    const uint32_t baseBits = baseNumberBits(tile->counts);
    uint32_t bit = 8 * tile->numbers, record = wordAt(tile, meshTileRecord(0) / 4);
    for (uint32_t i = 0; i < g; i++) {
      bit += baseBits + tileGroupTriangles(record) * tileGroupNumberBits(record);
      record = wordAt(tile, meshTileRecord(i + 1) / 4);
    }
    auto read = [&](uint32_t count) {
      uint64_t word;
      memcpy(&word, (const uint8_t*)tile + (bit >> 3), sizeof(word));
      const uint32_t value = uint32_t((word >> (bit & 7u)) & ((uint64_t(1) << count) - 1));
      bit += count;
      return value;
    };
    const uint32_t bits = tileGroupNumberBits(record), base = read(baseBits);
    bit += triangle * bits;
    return tile->primID + base + read(bits);
  }

  const MeshTileHeader* const tile;
  const uint32_t groups;

private:
  /*! Subtracts the shear (meshShear) on the sheared axis. */
  template<int vectors>
  __forceinline void unshear(const int axes[3], vintV (&at)[3][vectors]) const {
    const int m = int(meshShearedAxis(tile->meshInfo));
    const vintV slope0(slope[axes[0]]), slope1(slope[axes[1]]), slope2(slope[axes[2]]), half(8);
    for (int j = 0; j < vectors; j++) {
      const vintV shear = (slope0 * at[0][j] + slope1 * at[1][j] + slope2 * at[2][j] + half) >> 4;
      for (int i = 0; i < 3; i++) at[i][j] = at[i][j] - (shear & vintV(axes[i] == m ? -1 : 0));
    }
  }

  const bool isSheared;
  float spacing[3];
  int slope[3]; //!< factor of each coordinate in the shear, in 1/16
};
} // namespace embree::isa::cbvh
