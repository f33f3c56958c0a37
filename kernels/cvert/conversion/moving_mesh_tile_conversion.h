// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Converts moving mesh blocks to moving mesh tiles (format/mesh_tile.h) and back, with the same triangles, vertices at
 * all steps, and numbers. */

#include "../encoder/mesh_motion_encoder.h"
#include "mesh_tile_conversion.h"
#include <map>
#include <string>
#include <vector>

namespace cvert { inline namespace CVERT_ISA {
/*! Upper bound of the bytes that MovingMeshTileWriter writes. */
inline size_t maxBytesOfMovingMeshTile(uint32_t numSteps) {
  return meshTileHeaderBytes + sizeof(VertMotion) + numSteps * (sizeof(uint32_t) + 16 + maxBytesOfMeshTile);
}

/*! Writes the tile of a moving mesh block. */
class MovingMeshTileWriter {
public:
  /*! block: valid. tile: maxBytesOfMovingMeshTile, aligned to 4. Returns its size, or 0 if the block has no tile: on an
   *  axis of ranks, or with large groups or fields. */
  size_t write(const MeshHeader* block, uint8_t* tile) {
    const MeshView view(block);
    groups.clear();
    for (uint32_t g = 0; g < view.groups; g++) {
      if (groupTriangles(meshGroupByte(block, g)) > maxTileGroupTriangles) return 0;
      groups.emplace_back(view, g);
    }
    VertMotion motion = motionOfMesh(block);
    motion.steps = meshTileHeaderBytes + uint32_t(sizeof(motion));
    std::memset(tile, 0, meshTileHeaderBytes);
    MeshTileHeader& header = *(MeshTileHeader*)tile;
    setCommon(block, header);
    header.meshBytes = block->bytes;
    header.motion = meshTileHeaderBytes;
    std::memcpy(tile + header.motion, &motion, sizeof(motion));
    uint32_t end = motion.steps + uint32_t(sizeof(uint32_t)) * motion.numSteps;
    for (uint32_t step = 0; step < motion.numSteps; step++) {
      while (end % 16 != 0) tile[end++] = 0;
      std::memcpy(tile + motion.steps + sizeof(end) * step, &end, sizeof(end));
      const uint32_t bytes = writeStep(view, step, tile + end);
      if (bytes == 0) return 0;
      end += bytes;
    }
    return header.bytes = end;
  }

private:
  static void setCommon(const MeshHeader* block, MeshTileHeader& header) {
    header.surface = block->surface;
    header.primID = block->primID;
    header.counts = block->counts & 0x3FFF3FFFu;
    header.meshInfo = block->info & meshHasQuads;
  }

  uint32_t writeStep(const MeshView& view, uint32_t step, uint8_t* tile) {
    MeshTileHeader& header = *(MeshTileHeader*)tile;
    std::memset(tile, 0, meshTileHeaderBytes);
    setCommon(view.block, header);
    if (step > 0) header.meshInfo |= meshTileWithoutCorners;
    if (!setCoordinates(view, step, header)) return 0;
    uint8_t* at = tile + meshTileGroups(view.groups);
    for (uint32_t g = 0; g < view.groups; g++) {
      const DecodedMeshGroup& group = groups[g];
      const uint32_t numberBits = step == 0 ? std::min(groupNumberBits(meshRecord(view.block, g)), 31u) : 0;
      uint32_t record = group.numVertices | (group.numTriangles - 1) << 5 | numberBits << 10, bits[3], lower[3];
      for (uint32_t k = 0; k < 3; k++) {
        const uint32_t shift = (header.meshInfo >> (4 * k)) & 15u;
        uint32_t least = 0xFFFFFFFFu, most = 0;
        for (uint32_t i = 0; i < group.numVertices; i++) {
          least = std::min(least, coordinates[k][group.vertices[i]]);
          most = std::max(most, coordinates[k][group.vertices[i]]);
        }
        lower[k] = least >> shift << shift;
        bits[k] = bitWidth(most - lower[k]);
        if (bits[k] > maxTileFieldBits) return 0;
        record |= bits[k] << (15 + 5 * k);
        tile[meshTilePlanes(view.groups, k) + g] = uint8_t(least >> shift);
        tile[meshTilePlanes(view.groups, 3 + k) + g] = uint8_t(most >> shift);
      }
      const uint16_t offset = uint16_t(at - tile);
      std::memcpy(tile + meshTileRecord(g), &record, sizeof(record));
      std::memcpy(tile + meshTileOffset(view.groups, g), &offset, sizeof(offset));
      for (uint32_t c = 0; c < 3 && step == 0; c++) {
        BitWriter corners(at);
        for (uint32_t t = 0; t < group.numTriangles; t++)
          corners.write(group.indices[c][t], tileGroupCornerBits(record));
        at = corners.finish();
      }
      for (uint32_t k = 0; k < 3; k++) {
        BitWriter axis(at);
        for (uint32_t i = 0; i < group.numVertices; i++)
          axis.write(coordinates[k][group.vertices[i]] - lower[k], bits[k]);
        at = axis.finish();
      }
    }
    header.numbers = uint32_t(at - tile);
    if (step == 0) {
      const uint32_t numberBytes = (view.numberBegin[view.groups] + 7) / 8;
      std::memcpy(at, view.numbers, numberBytes);
      at += numberBytes;
    }
    while ((at - tile) % 4 != 0) *at++ = 0;
    return header.bytes = uint32_t(at - tile);
  }

  /*! Sets the header's origin, spacings and shifts, and the coordinates of all vertices, the least of which are 0.
   *  Returns false on an axis of ranks, or if coordinates are too large. */
  bool setCoordinates(const MeshView& view, uint32_t step, MeshTileHeader& header) {
    const uint32_t numVertices = meshVertices(view.block->counts);
    if (step == 0) {
      header.spacings = view.block->spacings;
      for (uint32_t v = 0; v < numVertices; v++) view.vertex(v, vertices[v]);
    } else {
      const MeshStepView later(view, step);
      header.spacings = later.step->spacings;
      for (uint32_t v = 0; v < numVertices; v++) later.vertex(v, vertices[v]);
    }
    if (hasRanksOnAnyAxis(header.spacings)) return false;
    for (uint32_t k = 0; k < 3; k++) {
      header.origin[k] = vertices[0][k];
      for (uint32_t v = 1; v < numVertices; v++) header.origin[k] = std::min(header.origin[k], vertices[v][k]);
      const double spacing = double(meshSpacing(header.spacings, k));
      uint32_t most = 0, shift = 0;
      for (uint32_t v = 0; v < numVertices; v++) {
        const double coordinate = (double(vertices[v][k]) - double(header.origin[k])) / spacing;
        if (!(coordinate < 8388608.0)) return false; // 256 times the largest unit of boxes
        coordinates[k][v] = uint32_t(coordinate);
        most = std::max(most, coordinates[k][v]);
      }
      while (most >> shift > 255) shift++;
      header.meshInfo |= shift << (4 * k);
    }
    return true;
  }

  std::vector<DecodedMeshGroup> groups;
  float vertices[maxMeshVertices][3];
  uint32_t coordinates[3][maxMeshVertices];
};

/*! Writes the block of a moving mesh tile. block: MeshMotionEncoder::maxBytes, aligned to 4. Returns its size. */
inline size_t movingMeshOfTile(const MeshTileHeader* tile, MeshMotionEncoder& encoder, uint8_t* block) {
  const VertMotion motion = motionOfMeshTile(tile);
  std::vector<MeshTileView> steps;
  for (uint32_t step = 0; step < motion.numSteps; step++) steps.emplace_back(meshTileOfStep(tile, step));
  const MeshTileView& first = steps[0];
  MeshTriangle triangles[maxMeshTriangles];
  uint32_t ids[maxMeshTriangles][3], count = 0;
  MeshGroups groups;
  /* A vertex that groups share has the same positions in all of them. A group's vertices with the same positions remain
   * different ones: they are counted. */
  std::map<std::string, uint32_t> idOf;
  std::vector<std::pair<uint32_t, uint32_t>> placeOf; // of each ID: group and vertex
  for (uint32_t g = 0; g < first.groups; g++) {
    std::map<std::string, uint8_t> numEqual;
    uint32_t idOfVertex[32];
    for (uint32_t v = 0; v < tileGroupVertices(first.record(g)); v++) {
      std::string key;
      for (const MeshTileView& step : steps) {
        float at[3];
        step.vertex(g, v, at);
        key.append((const char*)at, sizeof(at));
      }
      const uint8_t before = numEqual[key]++;
      key.push_back(char(before));
      const auto found = idOf.emplace(key, uint32_t(placeOf.size()));
      if (found.second) placeOf.emplace_back(g, v);
      idOfVertex[v] = found.first->second;
    }
    for (uint32_t t = 0; t < first.triangles(g); t++, count++) {
      for (uint32_t c = 0; c < 3; c++) {
        const uint32_t v = first.corner(g, t, c);
        first.vertex(g, v, triangles[count].corners[c]);
        ids[count][c] = idOfVertex[v];
      }
      triangles[count].number = first.number(g, t);
    }
    groups.add(count);
  }
  const MovingCluster cluster = {triangles,     ids,          groups,     false,
                                 tile->surface, motion.begin, motion.end, motion.numSteps};
  MeshStatistics statistics;
  const size_t bytes = encoder.encodeInOrder(cluster, block, statistics, [&](uint32_t step, uint32_t id, float out[3]) {
    steps[step].vertex(placeOf[id].first, placeOf[id].second, out);
  });
  ((MeshHeader*)block)->info |= tile->meshInfo & meshHasQuads;
  return bytes;
}

/*! Bytes of all steps but the first, of a moving mesh block or mesh tile; 0 for those at rest. */
inline uint32_t laterStepBytes(const MeshHeader* block) {
  return isMovingMesh(block) ? block->bytes - block->motion : 0;
}
inline uint32_t laterStepBytes(const MeshTileHeader* tile) {
  if (!isMovingMeshTile(tile)) return 0;
  return tile->bytes - uint32_t((const uint8_t*)meshTileOfStep(tile, 1) - (const uint8_t*)tile);
}
}} // namespace cvert::CVERT_ISA
