// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* CachedMeshBlock for moving blocks, at a time between two steps. Interpolates between the ends of a segment as
 * MovingVertBlock does (moving_block.h explains why surfaces stay watertight). */

#include "cached_mesh.h"
#include "interpolation.h"
#include "mesh_motion_decoder.h"

namespace embree::isa::cbvh {
class MovingMeshBlock {
public:
  /*! block: a MeshHeader, see cached_mesh.h. */
  __forceinline MovingMeshBlock(const VertRay&, const VertHeader* block, const TimeInMotion& at)
    : cache(MeshMotionCache::ofThread()),
      block((const MeshHeader*)block),
      segment(at.segment),
      fraction(at.fraction) {
    trianglesAtTime.key = ~size_t(0);
  }

  __forceinline const GroupBoxes* decodedBoxes() const {
    const SegmentKey key = {block, segment, 0};
    return likely(cache.blockEntry(block, segment).key == key) ? &boxes() : nullptr;
  }

  /*! Always true: loading a file checks its moving blocks. */
  __forceinline bool isValid() const { return true; }

  /*! Always true, see CachedMeshBlock. */
  __forceinline bool mayIntersect(const VertRayBase<float>&, float, float) const { return true; }

  /*! Boxes of groups at the time. The reference is valid as long as this object. */
  __forceinline const GroupBoxes& boxes() const {
    if (isInterpolated) return boxesAtTime;
    const MeshSegmentEntry& entry = segmentEntry();
    boxesAtTime.shearedAxis = 3;
    boxesAtTime.lanes = entry.first.lanes;
    for (int k = 0; k < 3; k++) {
      boxesAtTime.origin[k] = (1.0f - fraction) * entry.origins[0][k] + fraction * entry.origins[1][k];
      boxesAtTime.extent[k] = entry.extent[k];
      boxesAtTime.shear[k] = 0.0f;
    }
    const Interpolator interpolator(fraction);
    for (int k = 0; k < 3; k++)
      for (int side = 0; side < 2; side++)
        interpolator.interpolate(entry.planes[0][k].at[side], entry.planes[1][k].at[side], 16,
                                 boxesAtTime.planes[k].at[side]);
    isInterpolated = true;
    return boxesAtTime;
  }

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
  __forceinline const MeshSegmentEntry& segmentEntry() const {
    MeshSegmentEntry& entry = cache.blockEntry(block, segment);
    const SegmentKey key = {block, segment, 0};
    if (unlikely(!(entry.key == key))) decode(entry);
    return entry;
  }

  __noinline void decode(MeshSegmentEntry& entry) const {
    entry.key = {block, segment, 0};
    MeshMotionDecoder(block).decode(segment, entry);
  }

  __noinline void decode(uint32_t g, uint32_t half, SegmentTriangles& entry) const {
    const MeshSegmentEntry& blockEntry = segmentEntry();
    entry.key = {block, segment, 16 * half + g};
    MeshMotionDecoder(block).triangles(blockEntry, g, half, entry);
  }

  __forceinline void interpolate(uint32_t g, uint32_t half) const {
    const uint32_t lane = 16 * half + g;
    SegmentTriangles& entry = cache.groupEntry(block, segment, lane);
    const SegmentKey key = {block, segment, lane};
    if (unlikely(!(entry.key == key))) decode(g, half, entry);
    trianglesAtTime.key = lane;
    trianglesAtTime.hasNextHalf = entry.begin.hasNextHalf;
    trianglesAtTime.lanes = entry.begin.lanes;
    trianglesAtTime.numVertices = entry.begin.numVertices;
    memcpy(trianglesAtTime.corners, entry.begin.corners, sizeof(trianglesAtTime.corners));
    const Interpolator interpolator(fraction);
    for (int k = 0; k < 3; k++)
      interpolator.interpolate(entry.begin.vertices.at[k], entry.end.at[k], 32, trianglesAtTime.vertices.at[k]);
  }

  MeshMotionCache& cache;
  const MeshHeader* block;
  const uint32_t segment;
  const float fraction;
  mutable bool isInterpolated = false; //!< boxesAtTime is set
  mutable GroupBoxes boxesAtTime;
  mutable MeshTriangles trianglesAtTime; //!< the key is 16 half + group, or ~0
};

__forceinline VertTriangle triangleOf(const MovingMeshBlock& cached, uint32_t g, uint32_t index) {
  return triangleOfMesh(cached, g, index);
}

__forceinline MeshGroupTriangles groupTrianglesHitByLine(const VertRay& ray, const MovingMeshBlock& cached,
                                                         uint32_t g) {
  return MeshGroupTriangles(ray, cached, g);
}

__forceinline SurfacePoint pointOfHit(const MovingMeshBlock& cached, const VertHeader*, uint32_t g, uint32_t index,
                                      const VertTriangle::Sides& sides) {
  return cached.point(g, index, clampParameter(sides.w1 / sides.sum), clampParameter(sides.w2 / sides.sum));
}
} // namespace embree::isa::cbvh
