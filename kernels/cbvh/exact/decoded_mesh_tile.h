// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A mesh tile, or a moving one at a time between two steps, as PointSearch expects mesh blocks: boxes of groups, and a
 * decoded group at a time. */

#include "moving_mesh_block.h"

namespace embree::isa::cbvh {
/*! tile: at rest, or a step of a moving one. */
class DecodedMeshTile {
public:
  explicit DecodedMeshTile(const MeshTileHeader* header) : tile(header), decoded(~0u) {
    const uint32_t info = header->meshInfo, spacings = header->spacings;
    const bool isSheared = (info & 0x03FF0000u) != 0;
    groupBoxes.shearedAxis = isSheared ? int(meshShearedAxis(info)) : 3;
    groupBoxes.lanes = (1u << tile.groups) - 1u;
    float extent[3], sheared = 0.0f;
    for (uint32_t k = 0; k < 3; k++) {
      const bool isAxis = int(k) == groupBoxes.shearedAxis;
      const float spacing = meshSpacing(spacings, k), unit = floatOfBits(bitsOfFloat(spacing) + (shiftOf(k) << 23));
      groupBoxes.origin[k] = header->origin[k];
      groupBoxes.shear[k] = header->shear[k];
      extent[k] = 256.0f * unit;
      sheared += header->shear[k] * extent[k] * (header->shear[k] < 0.0f ? -1.0f : 1.0f);
      const float origin = isAxis ? 0.0f : header->origin[k];
      for (uint32_t g = 0; g < 16; g++) {
        const bool isPresent = g < tile.groups;
        const float lower = isPresent ? float(byteOf(k, g)) : 0.0f,
                    upper = isPresent ? float(byteOf(3 + k, g) + 1) : 0.0f;
        groupBoxes.planes[k].at[0][g] = origin + (lower * unit - (isAxis ? 0.5f * spacing : 0.0f));
        groupBoxes.planes[k].at[1][g] = origin + upper * unit;
      }
    }
    for (uint32_t k = 0; k < 3; k++)
      groupBoxes.extent[k] = int(k) == groupBoxes.shearedAxis ? sheared + meshSpacing(spacings, k) : extent[k];
  }

  const GroupBoxes& boxes() const { return groupBoxes; }

  /*! As CachedMeshBlock::triangles. Valid until the next call for another group. */
  const MeshTriangles& triangles(uint32_t g, uint32_t) const {
    if (g != decoded) decode(g);
    return group;
  }

  /*! As CachedMeshBlock::point. */
  SurfacePoint point(uint32_t g, uint32_t index, float w1, float w2) const {
    return pointOfMesh(tile.tile->meshInfo, tile.number(g, index), w1, w2);
  }

private:
  uint32_t shiftOf(uint32_t axis) const { return (tile.tile->meshInfo >> (4 * axis)) & 15u; }
  uint32_t byteOf(uint32_t plane, uint32_t g) const {
    return byteAt(tile.tile, meshTilePlanes(tile.groups, plane) + g);
  }

  void decode(uint32_t g) const {
    const MeshTileGroup from = tile.group(g);
    const int axes[3] = {0, 1, 2}, vectors = 32 / vectorWidth;
    vfloatV at[3][vectors];
    tile.vertices<vectors>(from, axes, at);
    for (int k = 0; k < 3; k++)
      for (int j = 0; j < vectors; j++) vfloatV::store(group.vertices.at[k] + vectorWidth * j, at[k][j]);
    memset(group.corners, 0, sizeof(group.corners));
    for (uint32_t t = 0; t < from.numTriangles && !(tile.info() & meshTileWithoutCorners); t++)
      for (uint32_t c = 0; c < 3; c++) group.corners[c][t] = from.corner(t, c);
    group.key = 0;
    group.hasNextHalf = false;
    group.lanes = uint16_t(0xFFFFu >> (maxTileGroupTriangles - from.numTriangles));
    group.numVertices = uint8_t(from.numVertices);
    decoded = g;
  }

  const MeshTileBlock tile;
  GroupBoxes groupBoxes;
  mutable uint32_t decoded; //!< group in `group`, or ~0
  mutable MeshTriangles group;
};

class DecodedMovingMeshTile {
public:
  DecodedMovingMeshTile(const MeshTileHeader* tile, const TimeInMotion& at)
    : first(meshTileOfStep(tile, 0)),
      begin(meshTileOfStep(tile, at.segment)),
      end(meshTileOfStep(tile, at.segment + 1)),
      interpolator(at.fraction) {
    groupBoxes = begin.boxes();
    const GroupBoxes& last = end.boxes();
    for (int k = 0; k < 3; k++) {
      const float from = groupBoxes.origin[k], to = last.origin[k], extent = max(groupBoxes.extent[k], last.extent[k]);
      groupBoxes.origin[k] = (1.0f - at.fraction) * from + at.fraction * to;
      groupBoxes.extent[k] = extent + motionSlack(from, to, extent);
      for (int side = 0; side < 2; side++)
        interpolator.interpolate(groupBoxes.planes[k].at[side], last.planes[k].at[side], 16,
                                 groupBoxes.planes[k].at[side]);
    }
  }

  const GroupBoxes& boxes() const { return groupBoxes; }

  const MeshTriangles& triangles(uint32_t g, uint32_t half) const {
    group = first.triangles(g, half);
    const MeshTriangles &from = begin.triangles(g, half), &to = end.triangles(g, half);
    for (int k = 0; k < 3; k++)
      interpolator.interpolate(from.vertices.at[k], to.vertices.at[k], 32, group.vertices.at[k]);
    return group;
  }

  SurfacePoint point(uint32_t g, uint32_t index, float w1, float w2) const { return first.point(g, index, w1, w2); }

private:
  const DecodedMeshTile first, begin, end;
  const Interpolator interpolator;
  GroupBoxes groupBoxes;
  mutable MeshTriangles group;
};
} // namespace embree::isa::cbvh
