// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* CachedVertBlock for moving blocks, at a time between two steps. Interpolates between the ends of a segment, which are
 * decoded into the thread's cache if necessary.
 *
 * Vertices and planes are interpolated by the same operations, which round monotonically: an unsheared plane that
 * bounds a vertex at both ends also bounds it in between. Shared vertices stay equal, so surfaces stay watertight. */

#include "interpolation.h"
#include "motion_decoder.h"

namespace embree::isa::cbvh {
class MovingVertBlock {
public:
  __forceinline MovingVertBlock(const VertRay&, const VertHeader* block, const TimeInMotion& at)
    : MovingVertBlock(block, at) {}

  __forceinline MovingVertBlock(const VertHeader* block, const TimeInMotion& at)
    : cache(MotionCache::ofThread()),
      block(block),
      segment(at.segment),
      fraction(at.fraction),
      lane(~0u) {}

  /*! Boxes of groups if the segment is in the cache, otherwise null. */
  __forceinline const GroupBoxes* decodedBoxes() const {
    const SegmentKey key = {block, segment, 0};
    return likely(cache.blockEntry(block, segment).key == key) ? &boxes() : nullptr;
  }

  /*! Always true: loading a file checks its moving blocks. */
  __forceinline bool isValid() const { return true; }

  /*! Returns false if the ray misses the block's bounds between tNear and tFar. Decodes nothing. */
  __forceinline bool mayIntersect(const VertRayBase<float>& ray, float tNear, float tFar) const {
    const SegmentBounds segmentBounds(block, segment);
    if (unlikely(segmentBounds.raw)) return true;
    BlockBounds bounds;
    segmentBounds.set(fraction, bounds);
    return intersectsBounds<float>(ray, bounds, tNear, tFar);
  }

  /*! Boxes of groups at the time. The reference is valid as long as this object. */
  __forceinline const GroupBoxes& boxes() const {
    if (isInterpolated) return boxesAtTime;
    const VertSegmentEntry& entry = segmentEntry();
    boxesAtTime.shearedAxis = entry.shearedAxis;
    boxesAtTime.lanes = entry.lanes;
    for (int k = 0; k < 3; k++) {
      boxesAtTime.origin[k] = (1.0f - fraction) * entry.origins[0][k] + fraction * entry.origins[1][k];
      boxesAtTime.extent[k] = entry.extent[k];
      boxesAtTime.shear[k] = entry.shear[k];
    }
    const Interpolator interpolator(fraction);
    for (int k = 0; k < 3; k++)
      for (int side = 0; side < 2; side++)
        interpolator.interpolate(entry.planes[0][k].at[side], entry.planes[1][k].at[side], 16,
                                 boxesAtTime.planes[k].at[side]);
    isInterpolated = true;
    return boxesAtTime;
  }

  /*! Vertices of a group at the time, in world space. The reference is valid until the next call with another
   *  group. */
  __forceinline const CellVertices& vertices(uint32_t lane) const {
    if (lane != this->lane) interpolate(lane);
    return laneVertices;
  }

private:
  __forceinline const VertSegmentEntry& segmentEntry() const {
    VertSegmentEntry& entry = cache.blockEntry(block, segment);
    const SegmentKey key = {block, segment, 0};
    if (unlikely(!(entry.key == key))) decode(entry);
    return entry;
  }

  __noinline void decode(VertSegmentEntry& entry) const {
    entry.key = {block, segment, 0};
    MotionDecoder(block).decode(segment, entry);
  }

  __noinline void decode(uint32_t lane, SegmentVertices& entry) const {
    const VertSegmentEntry& blockEntry = segmentEntry();
    entry.key = {block, segment, lane};
    MotionDecoder(block).vertices(blockEntry, lane, entry);
  }

  __forceinline void interpolate(uint32_t lane) const {
    this->lane = lane;
    SegmentVertices& entry = cache.groupEntry(block, segment, lane);
    const SegmentKey key = {block, segment, lane};
    if (unlikely(!(entry.key == key))) decode(lane, entry);
    const Interpolator interpolator(fraction);
    for (int k = 0; k < 3; k++)
      interpolator.interpolate(entry.vertices[0].at[k], entry.vertices[1].at[k], cellVectors * vectorWidth,
                               laneVertices.at[k]);
  }

  MotionCache& cache;
  const VertHeader* block;
  const uint32_t segment;
  const float fraction;
  mutable uint32_t lane;               //!< lane of laneVertices, or ~0
  mutable bool isInterpolated = false; //!< boxesAtTime is set
  mutable GroupBoxes boxesAtTime;
  mutable CellVertices laneVertices;
};
} // namespace embree::isa::cbvh
