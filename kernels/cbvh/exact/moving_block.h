// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* CachedVertBlock and TileBlock for moving blocks and tiles, at a time between two steps. Interpolates between the ends
 * of a segment, the time between two steps; those of blocks are decoded into the thread's cache if necessary.
 * moving_mesh_block.h does so for meshes.
 *
 * Vertices and planes are interpolated by the same operations, which round monotonically: an unsheared plane that
 * bounds a vertex at both ends also bounds it in between. Shared vertices stay equal, so surfaces stay watertight. */

#include "motion_decoder.h"
#include "tile_block.h"
#include <limits>

namespace embree::isa::cbvh {
/*! fraction: 0 at the beginning of the segment, 1 at its end. */
struct Interpolator {
  const vfloatV weightOfBegin, weightOfEnd;
  __forceinline explicit Interpolator(float fraction) : weightOfBegin(1.0f - fraction), weightOfEnd(fraction) {}

  /*! Rounds as Embree's lerp, so that vertices equal Embree's if the ends do. */
  __forceinline vfloatV operator()(const vfloatV& a, const vfloatV& b) const {
    return madd(weightOfBegin, a, weightOfEnd * b);
  }

  /*! Interpolates arrays, which must be aligned to vectors and padded to whole vectors. */
  __forceinline void interpolate(const float* a, const float* b, uint32_t count, float* out) const {
    for (uint32_t l = 0; l < count; l += vectorWidth)
      vfloatV::store(out + l, (*this)(vfloatV::load(a + l), vfloatV::load(b + l)));
  }
};

/*! Sets lanes and shear of a segment's boxes, by the type of the segment's entry. */
template<typename Entry>
struct SegmentAxes;

template<>
struct SegmentAxes<VertSegmentEntry> {
  static __forceinline void set(const VertSegmentEntry& entry, GroupBoxes& boxes) {
    boxes.shearedAxis = entry.shearedAxis;
    boxes.lanes = entry.lanes;
    for (int k = 0; k < 3; k++) boxes.shear[k] = entry.shear[k];
  }
};

/*! Common part of moving blocks of quads and of meshes. Entry: of a block's segment in a Cache. */
template<typename Header, typename Decoder, typename Cache, typename Entry>
class MovingBlock {
public:
  /*! Boxes of groups if the segment is in the cache, otherwise null. */
  __forceinline const GroupBoxes* decodedBoxes() const {
    return likely(cache.blockEntry(block, segment).key == keyOf(0)) ? &boxes() : nullptr;
  }

  /*! Always true: loading a file checks its moving blocks. */
  __forceinline bool isValid() const { return true; }

  /*! Boxes of groups at the time. The reference is valid as long as this object. */
  __forceinline const GroupBoxes& boxes() const {
    if (isInterpolated) return boxesAtTime;
    const Entry& entry = segmentEntry();
    SegmentAxes<Entry>::set(entry, boxesAtTime);
    for (int k = 0; k < 3; k++) {
      boxesAtTime.origin[k] = (1.0f - fraction) * entry.origins[0][k] + fraction * entry.origins[1][k];
      boxesAtTime.extent[k] = entry.extent[k];
    }
    const Interpolator interpolator(fraction);
    for (int k = 0; k < 3; k++)
      for (int side = 0; side < 2; side++)
        interpolator.interpolate(entry.planes[0][k].at[side], entry.planes[1][k].at[side], 16,
                                 boxesAtTime.planes[k].at[side]);
    isInterpolated = true;
    return boxesAtTime;
  }

protected:
  __forceinline MovingBlock(const Header* block, const TimeInMotion& at)
    : cache(Cache::ofThread()),
      block(block),
      segment(at.segment),
      fraction(at.fraction) {}

  /*! lane: of a group; 0 for the block. */
  __forceinline SegmentKey keyOf(uint32_t lane) const { return SegmentKey{block, segment, lane}; }

  __forceinline const Entry& segmentEntry() const {
    Entry& entry = cache.blockEntry(block, segment);
    if (unlikely(!(entry.key == keyOf(0)))) decode(entry);
    return entry;
  }

  Cache& cache;
  const Header* block;
  const uint32_t segment;
  const float fraction;

private:
  __noinline void decode(Entry& entry) const {
    entry.key = keyOf(0);
    Decoder(block).decode(segment, entry);
  }

  mutable bool isInterpolated = false; //!< boxesAtTime is set
  mutable GroupBoxes boxesAtTime;
};

class MovingVertBlock : public MovingBlock<VertHeader, MotionDecoder, MotionCache, VertSegmentEntry> {
public:
  static const bool isMesh = false; //!< see hits1.h

  __forceinline MovingVertBlock(const VertRay&, const VertHeader* block, const TimeInMotion& at)
    : MovingVertBlock(block, at) {}

  __forceinline MovingVertBlock(const VertHeader* block, const TimeInMotion& at) : MovingBlock(block, at), lane(~0u) {}

  /*! Returns false if the ray misses the block's bounds between tNear and tFar. Decodes nothing. */
  __forceinline bool mayIntersect(const VertRayBase<float>& ray, float tNear, float tFar) const {
    const SegmentBounds segmentBounds(block, segment);
    if (unlikely(segmentBounds.raw)) return true;
    BlockBounds bounds;
    segmentBounds.set(fraction, bounds);
    return intersectsBounds<float>(ray, bounds, tNear, tFar);
  }

  /*! Vertices of a group at the time, in world space. The reference is valid until the next call with another
   *  group. */
  __forceinline const CellVertices& vertices(uint32_t lane) const {
    if (lane != this->lane) interpolate(lane);
    return laneVertices;
  }

private:
  __noinline void decode(uint32_t lane, SegmentVertices& entry) const {
    const VertSegmentEntry& blockEntry = segmentEntry();
    entry.key = keyOf(lane);
    MotionDecoder(block).vertices(blockEntry, lane, entry);
  }

  __forceinline void interpolate(uint32_t lane) const {
    this->lane = lane;
    SegmentVertices& entry = cache.groupEntry(block, segment, lane);
    if (unlikely(!(entry.key == keyOf(lane)))) decode(lane, entry);
    const Interpolator interpolator(fraction);
    for (int k = 0; k < 3; k++)
      interpolator.interpolate(entry.vertices[0].at[k], entry.vertices[1].at[k], cellVectors * vectorWidth,
                               laneVertices.at[k]);
  }

  mutable uint32_t lane; //!< lane of laneVertices, or ~0
  mutable CellVertices laneVertices;
};

class MovingTileBlock {
public:
  __forceinline MovingTileBlock(const VertHeader* tile, const TimeInMotion& at)
    : tile(tile),
      begin(tileOfStep(tile, at.segment)),
      end(tileOfStep(tile, at.segment + 1)),
      interpolator(at.fraction) {}

  /*! As TileBlock::vertices. */
  __forceinline void vertices(const uint32_t leaves[tileLeavesAtOnce], const int axes[3], LeafVectors out[3]) const {
    LeafVectors atEnd[3];
    begin.vertices(leaves, axes, out);
    end.vertices(leaves, axes, atEnd);
    for (int i = 0; i < 3; i++)
      for (int n = 0; n < LeafLayout::vectors; n++) out[i].at[n] = interpolator(out[i].at[n], atEnd[i].at[n]);
  }

  __forceinline uint32_t flip(uint32_t octant) const { return begin.flip(octant); }

  const VertHeader* const tile;

private:
  const TileBlock begin, end;
  const Interpolator interpolator;
};

/*! motionSlack on all axes. The summand covers weighted units that are flushed to 0, 255 of them per step. */
__forceinline vfloat4 slackOfMotion(const vfloat4 origins[2], const vfloat4& extent) {
  return madd(max(abs(origins[0]), abs(origins[1])) + vfloat4(2.0f) * extent, vfloat4(1.0f / 1048576.0f),
              vfloat4(1024.0f * std::numeric_limits<float>::min()));
}

/*! Boxes of a moving tile's leaves at a time between two steps: on axis k, planes are
 *
 *    origin[k] + byte of begin * units[0][k] + byte of end * units[1][k],
 *
 *  moved outwards by slack[k] because vertices, planes and origins are rounded. The fourth lanes are 0. */
struct MovingLeafPlanes {
  vfloat4 origin, units[2], slack;
  const uint8_t* boxes[2]; //!< of begin and end

  __forceinline MovingLeafPlanes(const VertHeader* tile, const TimeInMotion& at) {
    const float weights[2] = {1.0f - at.fraction, at.fraction};
    vfloat4 origins[2], largestSpacing(0.0f);
    for (uint32_t e = 0; e < 2; e++) {
      const VertHeader* const step = tileOfStep(tile, at.segment + e);
      const vfloat4 spacing = withoutFourth(spacingsOfTile(step)) * vfloat4(float(tileScale(step)));
      origins[e] = withoutFourth(vfloat4::loadu(step->origin));
      units[e] =
          vfloat4(vint4(extend8(loadFour((const uint8_t*)step + tileBoxStepOffset)))) * spacing * vfloat4(weights[e]);
      largestSpacing = max(largestSpacing, spacing);
      boxes[e] = (const uint8_t*)step + tileBoxesOffset(step->info);
    }
    origin = madd(vfloat4(weights[0]), origins[0], vfloat4(weights[1]) * origins[1]);
    // planes are at most 255 steps of at most 255 spacings from the origin
    extent = vfloat4(float((maxBoxByte + 1) * maxBoxByte)) *
             max(max(largestSpacing, shuffle<1, 2, 0, 1>(largestSpacing)), shuffle<2, 0, 1, 2>(largestSpacing));
    slack = slackOfMotion(origins, extent);
  }

  /*! The slack for distances of planes from a point. offset: of the point from the origin. A plane has a second product
   *  and sum, worth 2 more per distance than in tiles at rest. */
  __forceinline vfloat4 slackOf(const vfloat4& offset) const {
    return madd(vfloat4((tileSlackUlps + 4.0f) * floatUlp), abs(offset) + extent, slack);
  }

private:
  vfloat4 extent; //!< bound of the distance from the origin to planes, on any axis
};
} // namespace embree::isa::cbvh
