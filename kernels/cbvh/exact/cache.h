// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoded cVERT blocks in the cache of a thread (base/thread_cache.h). Blocks and groups have separate entries, because
 * each ray that reaches a block needs the groups' boxes, but few rays need a certain group's vertices. */

#include "../base/thread_cache.h"
#include "tables.h"

namespace embree::cbvh {
/*! World positions or lattice coordinates of a cell's vertices: [axis][laneOfVertex]. Other lanes are undefined. */
struct alignas(64) CellVertices {
  float at[3][VertTables::lanes];
};

/*! Lattice coordinates of a cell's vertices: x, y, z and 0 per lane. 26, because two are stored at a time. */
struct alignas(16) CellCoordinates {
  uint16_t at[26][4];
};

/*! Lower and upper planes of the groups' boxes on one axis: world coordinates, or relative to the block's origin on
 *  the sheared axis. Group (x,y) is in lane x + 4 y. Other lanes are undefined. */
struct alignas(64) GroupPlanes {
  float at[2][16];
};

/*! Axes of a block's boxes: the world's axes, but one may be sheared. */
struct VertAxes {
  int shearedAxis; //!< 3 for none, as in raw blocks
  float origin[3]; //!< of the block
  float extent[3]; //!< by axis: at least the distance of vertices and planes from the origin
  float shear[3];  //!< the sheared coordinate is the sum of shear[k]*(p[k]-origin[k])
};

/*! Boxes of a block's groups. */
struct GroupBoxes : public VertAxes {
  uint32_t lanes;        //!< mask of lanes with a group
  GroupPlanes planes[3]; //!< by axis
};

/*! Entry of a block: the boxes of its groups, and what decoding their vertices requires. In a raw block, words,
 *  fieldOffsets and corners are undefined. */
struct VertBlockEntry : public GroupBoxes {
  uint32_t words[16];        //!< word of each group's cell
  uint16_t fieldOffsets[16]; //!< offset of each group's fields in the block
  CellCoordinates corners;   //!< corners of the groups
  const void* block;         //!< block that the entry belongs to, or null
};
/* 12: members occupy 760 bytes in this order. Every further cache line would add 16 or 32 KiB to a thread's cache,
 * which the size of the second-level cache limits (traversal/thread_cache.cpp). */
static_assert(sizeof(VertBlockEntry) == 12 * 64, "VertBlockEntry must occupy exactly 12 cache lines");

/*! Key of a group in the cache. Unique, because lane < 16 and blocks are aligned to 16 bytes. */
__forceinline size_t keyOfGroup(const void* block, uint32_t lane) { return size_t(block) + lane; }

class VertEntries {
public:
  /*! If the entry's `block` differs, the caller must decode the block into the entry and set `block`. 512: most
   *  full blocks have more bytes, so that neighboring blocks have different entries. */
  __forceinline VertBlockEntry& blockEntry(const void* block) {
    return blocks[blocks.indexOf(localityHashOfBlock(block, 512))];
  }

  /*! Index of the entry of the group in lane 0; the other lanes follow. 32: 512 bytes per 16 groups. */
  static __forceinline size_t firstGroupIndex(const void* block) {
    return GroupVertices::indexOf(localityHashOfBlock(block, 32));
  }

  /*! Key and vertices of the entry of a group. If the key differs from keyOfGroup, the caller must decode the group
   *  into the entry and set the key. */
  __forceinline size_t& groupKey(size_t index) { return keys[index]; }
  __forceinline CellVertices& groupVertices(size_t index) { return vertices[index]; }

  void clear() {
    for (size_t i = 0; i < blocks.size(); i++) blocks[i].block = nullptr;
    for (size_t i = 0; i < keys.size(); i++) keys[i] = 0;
  }

private:
  static const size_t numGroups = 768; //!< limited by a core's cache, see traversal/thread_cache.cpp
  typedef CacheEntries<CellVertices, numGroups, 15> GroupVertices;

  CacheEntries<VertBlockEntry, 256> blocks;
  CacheEntries<size_t, numGroups, 15> keys; //!< of groups; apart from the vertices, which fill whole cache lines
  GroupVertices vertices;                   //!< in world space
};

/* --- moving blocks --- */

/*! Identifies a segment of a block, or of one of its groups. lane: lane of the group; 0 for the block. */
struct SegmentKey {
  const void* block;
  uint32_t segment, lane;

  __forceinline bool operator==(const SegmentKey& other) const {
    return block == other.block && segment == other.segment && lane == other.lane;
  }
};

/*! Cells of a time step. */
struct StepCells {
  alignas(64) uint16_t fieldOffsets[16]; //!< offset of each group's fields from the start of the step
  uint32_t words[16];                    //!< word of each group's cell
  CellCoordinates corners;               //!< corners of the groups
};

/*! Entry of a block in a segment. [e]: 0 for the beginning and 1 for the end of the segment. VertAxes::origin is
 *  unused. */
struct VertSegmentEntry : public VertAxes {
  uint32_t lanes;           //!< mask of lanes with a group
  SegmentKey key;           //!< of the block
  float origins[2][3];      //!< [e][axis]
  GroupPlanes planes[2][3]; //!< [e][axis]
  StepCells steps[2];       //!< [e]; undefined for a raw step
};

/*! Entry of a group in a segment. */
struct SegmentVertices {
  SegmentKey key;           //!< of the group
  CellVertices vertices[2]; //!< in world space, at the beginning and at the end of the segment
};

/*! Cache of moving blocks. BlockEntry, GroupEntry: types of the entries, with a SegmentKey `key`. blockStep,
 *  groupStep: arguments of localityHashOfBlock. */
template<typename BlockEntry, typename GroupEntry, size_t blockStep, size_t groupStep, size_t numBlocks,
         size_t numGroups>
class SegmentEntries {
public:
  /* If the entry's key differs, the caller must decode the segment into the entry and set the key. */
  __forceinline BlockEntry& blockEntry(const void* block, uint32_t segment) {
    return blocks[blocks.indexOf(localityHashOfBlock(block, blockStep) + segment)];
  }
  __forceinline GroupEntry& groupEntry(const void* block, uint32_t segment, uint32_t lane) {
    // 7: the lanes of adjacent groups differ by 1, 3, 4 or 5. A group therefore does not share its entry with a
    // neighbor in the next segment.
    return groups[groups.indexOf(localityHashOfBlock(block, groupStep) + lane + 7 * segment)];
  }

  void clear() {
    for (size_t i = 0; i < blocks.size(); i++) blocks[i].key.block = nullptr;
    for (size_t i = 0; i < groups.size(); i++) groups[i].key.block = nullptr;
  }

private:
  CacheEntries<BlockEntry, numBlocks> blocks;
  CacheEntries<GroupEntry, numGroups> groups;
};

/* 323 is odd: blocks at distances of a power of two would otherwise share few entries. */
typedef SegmentEntries<VertSegmentEntry, SegmentVertices, 512, 32, 160, 323> MotionEntries;
typedef ThreadCache<VertEntries> VertCache;
typedef ThreadCache<MotionEntries> MotionCache;
extern template class ThreadCache<VertEntries>;
extern template class ThreadCache<MotionEntries>;
} // namespace embree::cbvh
