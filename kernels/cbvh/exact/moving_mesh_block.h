// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* CachedMeshBlock and MeshTileBlock for moving mesh blocks and mesh tiles, see moving_block.h. */

#include "cached_mesh.h"
#include "mesh_motion_decoder.h"
#include "mesh_tile_block.h"
#include "moving_block.h"

namespace embree::isa::cbvh {
template<>
struct SegmentAxes<MeshSegmentEntry> {
  static __forceinline void set(const MeshSegmentEntry& entry, GroupBoxes& boxes) {
    boxes.shearedAxis = 3;
    boxes.lanes = entry.first.lanes;
    for (int k = 0; k < 3; k++) boxes.shear[k] = 0.0f;
  }
};

class MovingMeshBlock : public MovingBlock<MeshHeader, MeshMotionDecoder, MeshMotionCache, MeshSegmentEntry> {
public:
  static const bool isMesh = true; //!< see hits1.h

  /*! block: a MeshHeader, see cached_mesh.h. */
  __forceinline MovingMeshBlock(const VertRay&, const VertHeader* block, const TimeInMotion& at)
    : MovingBlock((const MeshHeader*)block, at) {
    trianglesAtTime.key = ~size_t(0);
  }

  /*! Always true, see CachedMeshBlock. */
  __forceinline bool mayIntersect(const VertRayBase<float>&, float, float) const { return true; }

  /*! CachedMeshBlock::triangles at the time. The reference is valid until the next call with another g or
   *  half. */
  __forceinline const MeshTriangles& triangles(uint32_t g, uint32_t half) const {
    if (trianglesAtTime.key != 16 * half + g) interpolate(g, half);
    return trianglesAtTime;
  }

  /*! See CachedMeshBlock::point. */
  __forceinline SurfacePoint point(uint32_t g, uint32_t index, float w1, float w2) const {
    return pointOfMesh(block->info, MeshMotionDecoder(block).number(segmentEntry(), g, index), w1, w2);
  }

private:
  __noinline void decode(uint32_t g, uint32_t half, SegmentTriangles& entry) const {
    const MeshSegmentEntry& blockEntry = segmentEntry();
    entry.key = keyOf(16 * half + g);
    MeshMotionDecoder(block).triangles(blockEntry, g, half, entry);
  }

  __forceinline void interpolate(uint32_t g, uint32_t half) const {
    const uint32_t lane = 16 * half + g;
    SegmentTriangles& entry = cache.groupEntry(block, segment, lane);
    if (unlikely(!(entry.key == keyOf(lane)))) decode(g, half, entry);
    trianglesAtTime.key = lane;
    trianglesAtTime.hasNextHalf = entry.begin.hasNextHalf;
    trianglesAtTime.lanes = entry.begin.lanes;
    trianglesAtTime.numVertices = entry.begin.numVertices;
    memcpy(trianglesAtTime.corners, entry.begin.corners, sizeof(trianglesAtTime.corners));
    const Interpolator interpolator(fraction);
    for (int k = 0; k < 3; k++)
      interpolator.interpolate(entry.begin.vertices.at[k], entry.end.at[k], 32, trianglesAtTime.vertices.at[k]);
  }

  mutable MeshTriangles trianglesAtTime; //!< the key is 16 half + group, or ~0
};

/*! A group of a moving mesh tile: corners of step 0, vertices of both ends. */
struct MovingMeshTileGroup : public MeshTileGroup {
  MeshTileGroup ends[2];
  __forceinline MovingMeshTileGroup(const MeshTileGroup& first, const MeshTileGroup& begin, const MeshTileGroup& end)
    : MeshTileGroup(first),
      ends{begin, end} {}
};

class MovingMeshTileBlock {
public:
  typedef MovingMeshTileGroup Group;

  __forceinline MovingMeshTileBlock(const MeshTileHeader* tile, const TimeInMotion& at)
    : first(meshTileOfStep(tile, 0)),
      begin(meshTileOfStep(tile, at.segment)),
      end(meshTileOfStep(tile, at.segment + 1)),
      interpolator(at.fraction) {}

  __forceinline Group group(uint32_t g) const { return Group(first.group(g), begin.group(g), end.group(g)); }

  __forceinline uint32_t info() const { return first.info(); }

  __forceinline uint32_t number(uint32_t g, uint32_t triangle) const { return first.number(g, triangle); }

  /*! As MeshTileBlock::vertices. */
  template<int vectors>
  __forceinline void vertices(const Group& group, const int axes[3], vfloatV (&out)[3][vectors]) const {
    vfloatV atEnd[3][vectors];
    begin.vertices<vectors>(group.ends[0], axes, out);
    end.vertices<vectors>(group.ends[1], axes, atEnd);
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < vectors; j++) out[i][j] = interpolator(out[i][j], atEnd[i][j]);
  }

private:
  const MeshTileBlock first, begin, end;
  const Interpolator interpolator;
};

/*! MovingLeafPlanes for the boxes of a mesh tile's groups. Upper planes are after the byte. */
struct MovingGroupPlanes {
  vfloat4 origin, units[2], slack;
  const uint8_t* boxes[2]; //!< of begin and end, see meshTilePlanes
  const uint32_t groups;

  __forceinline MovingGroupPlanes(const MeshTileHeader* tile, const TimeInMotion& at)
    : groups(meshGroups(tile->counts)) {
    const float weights[2] = {1.0f - at.fraction, at.fraction};
    vfloat4 origins[2], largestUnit(0.0f);
    for (uint32_t e = 0; e < 2; e++) {
      const MeshTileHeader* const step = meshTileOfStep(tile, at.segment + e);
      const uint32_t info = step->meshInfo;
      const vint4 exponents(extend8(_mm_cvtsi32_si128(int(step->spacings)))),
          shifts(int(info & 15u), int((info >> 4) & 15u), int((info >> 8) & 15u), 0);
      const vfloat4 unit = withoutFourth(asFloat((exponents + shifts) << 23));
      origins[e] = withoutFourth(vfloat4::loadu(step->origin));
      units[e] = unit * vfloat4(weights[e]);
      largestUnit = max(largestUnit, unit);
      boxes[e] = (const uint8_t*)step + meshTilePlanes(groups, 0);
    }
    origin = madd(vfloat4(weights[0]), origins[0], vfloat4(weights[1]) * origins[1]);
    extent = vfloat4(256.0f) * largestUnit;
    slack = slackOfMotion(origins, extent);
  }

  /*! See MovingLeafPlanes. */
  __forceinline vfloat4 slackOf(const vfloat4& offset) const {
    return madd(vfloat4((tileSlackUlps + 4.0f) * floatUlp), abs(offset) + extent, slack);
  }

private:
  vfloat4 extent; //!< bound of the distance from the origin to planes, by axis
};
} // namespace embree::isa::cbvh
