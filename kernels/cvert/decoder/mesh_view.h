// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Locates parts of a mesh block, and decodes single vertices and numbers. */

#include "../format/mesh_block.h"

namespace cvert { inline namespace CVERT_ISA {
/*! bitsAt with all higher bits 0. */
inline uint32_t meshBitsAt(const uint8_t* data, uint32_t begin, uint32_t count) {
  return count == 0 ? 0 : bitsAt(data, begin, count) & (0xFFFFFFFFu >> (32 - count));
}

/*! The block must be valid (validateMesh) and must outlive this object. */
class MeshView {
public:
  const MeshHeader* const block;
  const uint32_t groups;
  const MeshLayout layout;
  /* By group, then the total. */
  uint32_t firstTriangle[maxMeshGroups + 1];    //!< index in the block
  uint32_t firstVertex[maxMeshGroups + 1];      //!< of the vertices that belong to the group
  uint32_t topologyBegin[maxMeshGroups + 1];    //!< first bit, relative to `topology`
  uint32_t vertexBegin[maxMeshGroups + 1];      //!< first bit of fields, relative to `vertices`
  uint32_t numberBegin[maxMeshGroups + 1];      //!< first bit, relative to `numbers`
  uint32_t fieldBits[maxMeshGroups][3];         //!< bits of a field, by group and axis
  const uint8_t *topology, *vertices, *numbers; //!< sections

  /*! Reads only the header, records and boxes. */
  explicit MeshView(const MeshHeader* block)
    : block(block),
      groups(meshGroups(block->counts)),
      layout(meshLayout(block->counts)) {
    const uint32_t numVertices = meshVertices(block->counts);
    firstTriangle[0] = firstVertex[0] = topologyBegin[0] = vertexBegin[0] = numberBegin[0] = 0;
    for (uint32_t g = 0; g < groups; g++) {
      const uint32_t group = meshGroupByte(block, g), record = meshRecord(block, g);
      uint32_t bits = 0;
      for (uint32_t k = 0; k < 3; k++)
        bits += fieldBits[g][k] = meshFieldBits(block->spacings, block->info, meshPlane(block, 3 + k, g), k);
      firstTriangle[g + 1] = firstTriangle[g] + groupTriangles(group);
      firstVertex[g + 1] = firstVertex[g] + groupOwnVertices(record);
      topologyBegin[g + 1] = topologyBegin[g] + meshTopology(group, record, numVertices).bits;
      vertexBegin[g + 1] = vertexBegin[g] + groupOwnVertices(record) * bits;
      numberBegin[g + 1] = numberBegin[g] + meshNumberBits(block->counts, group, record);
    }
    topology = (const uint8_t*)block + layout.topology;
    vertices = topology + (topologyBegin[groups] + 7) / 8;
    numbers = vertices + (vertexBegin[groups] + 7) / 8;
  }

  /*! Size in bytes, a multiple of 4, without later time steps. */
  uint32_t bytes() const {
    return (uint32_t(numbers - (const uint8_t*)block) + (numberBegin[groups] + 7) / 8 + 3) & ~3u;
  }

  uint32_t groupOfVertex(uint32_t v) const {
    uint32_t g = 0;
    while (g + 1 < groups && v >= firstVertex[g + 1]) g++;
    return g;
  }

  /*! Coordinates of a vertex; on the sheared axis, before the shear is subtracted. */
  void storedCoordinates(uint32_t v, uint32_t out[3]) const {
    const uint32_t g = groupOfVertex(v), *const bits = fieldBits[g];
    uint32_t at = vertexBegin[g] + (v - firstVertex[g]) * (bits[0] + bits[1] + bits[2]);
    for (uint32_t k = 0; k < 3; at += bits[k++])
      out[k] =
          meshBitsAt(vertices, at, bits[k]) + (meshPlane(block, k, g) << meshBoxShift(block->spacings, block->info, k));
  }

  void vertex(uint32_t v, float out[3]) const {
    uint32_t coordinates[3];
    storedCoordinates(v, coordinates);
    if (isSheared()) {
      const uint32_t m = meshShearedAxis(block->info);
      coordinates[m] -= uint32_t(meshShear(block->info, int(coordinates[(m + 1) % 3]), int(coordinates[(m + 2) % 3])));
    }
    for (uint32_t k = 0; k < 3; k++) out[k] = position(k, coordinates[k]);
  }

  /*! Number of triangle t of group g, for primitiveOfMesh. */
  uint32_t number(uint32_t g, uint32_t t) const {
    const uint32_t base = baseNumberBits(block->counts), bits = groupNumberBits(meshRecord(block, g));
    return block->primID + meshBitsAt(numbers, numberBegin[g], base) +
           meshBitsAt(numbers, numberBegin[g] + base + t * bits, bits);
  }

  bool isSheared() const { return (meshSlope(block->info, 1) | meshSlope(block->info, 2)) != 0; }

  /*! Box of a group in world space. On the sheared axis it bounds the sheared coordinate times the spacing, relative
   *  to the origin. */
  void groupBox(uint32_t g, float lower[3], float upper[3]) const {
    for (uint32_t k = 0; k < 3; k++) {
      const uint32_t shift = meshBoxShift(block->spacings, block->info, k), plane = meshPlane(block, k, g);
      const uint32_t begin = plane << shift, end = (plane + meshPlane(block, 3 + k, g) + 1) << shift;
      if (hasRanks(block->spacings, k)) {
        lower[k] = position(k, begin);
        upper[k] = position(k, end - 1);
        continue;
      }
      const bool sheared = isSheared() && k == meshShearedAxis(block->info);
      const float spacing = meshSpacing(block->spacings, k), origin = sheared ? 0.0f : block->origin[k];
      // meshShear rounds: a sheared coordinate may be 1/2 lower
      lower[k] = origin + (float(begin) - (sheared ? 0.5f : 0.0f)) * spacing;
      upper[k] = origin + float(end) * spacing;
    }
  }

private:
  /*! On the sheared axis, the coordinate may be negative, modulo 2^32. */
  float position(uint32_t k, uint32_t coordinate) const {
    if (hasRanks(block->spacings, k)) return floatOfRank(rankOfFloat(block->origin[k]) + coordinate);
    return block->origin[k] + float(int(coordinate)) * meshSpacing(block->spacings, k);
  }
};
}} // namespace cvert::CVERT_ISA
