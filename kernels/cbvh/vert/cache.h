// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoded cVERT blocks in the cache of a thread (thread_cache.h). */

#include "../base/thread_cache.h"
#include "tables.h"

namespace embree
{
  namespace cbvh
  {
    /*! By axis, one per lane. Lanes after the last vertex are undefined. */
    struct alignas(64) CellVertices { float at[3][VertTables::lanes]; };

    /*! Coordinates of the block: x, y, z and 0 per lane. */
    struct alignas(16) CellCoordinates { uint16_t at[26][4]; };

    /*! Planes on one axis, in world space; on the sheared axis, relative to the block's origin. Group (x,y) is in lane
     *  x + 4 y. Lanes without a group are undefined. */
    struct alignas(64) GroupPlanes { float at[2][16]; }; //!< lower, upper

    /*! world axes; one may be sheared */
    struct VertAxes
    {
      int axis;        //!< 3 for none, as in raw blocks
      float origin[3]; //!< origin of the block
      float extent[3]; //!< at least the distance of vertices and planes from the origin
      float shear[3];  //!< factors of world coordinates, relative to the origin, in the sheared coordinate
    };

    struct GroupBoxes : public VertAxes
    {
      uint32_t lanes;        //!< mask of lanes with a group
      GroupPlanes planes[3]; //!< by axis
    };

    /*! For a raw block, only axes, lanes and planes are set. */
    struct VertBoxes : public GroupBoxes
    {
      uint32_t words[16];    //!< word of each group's cell
      uint16_t fields[16];   //!< offset in the block of each group's fields
      CellCoordinates corners; //!< corners of the groups
      const void* block;     //!< block that the boxes belong to
    };
    static_assert(sizeof(VertBoxes) == 12*64,"VertBoxes must occupy exactly 12 cache lines");

    /*! Unique because blocks are aligned to 16 bytes. */
    __forceinline size_t keyOfGroup (const void* block, uint32_t lane) { return size_t(block) + lane; }

    class VertEntries
    {
    public:
      /*! If the slot's `block` differs, the caller must fill the slot and set it. */
      __forceinline VertBoxes& slot (const void* block) { return blocks[blocks.slot(slotOfBlock(block,512))]; }

      /*! The first of 16 slots of a block's groups, one per lane. If a slot's key differs, the caller must fill the
       *  slot and set it. */
      static __forceinline size_t groupSlots (const void* block) { return Groups::slot(slotOfBlock(block,32)); }
      __forceinline size_t& key (size_t slot) { return keys[slot]; }
      __forceinline CellVertices& vertices (size_t slot) { return groups[slot]; }

      void clear ()
      {
        for (size_t i=0; i<blocks.size(); i++) blocks[i].block = nullptr;
        for (size_t i=0; i<keys.size(); i++) keys[i] = 0;
      }

    private:
      static const size_t numGroups = 768;
      typedef CacheEntries<CellVertices,numGroups,15> Groups;

      CacheEntries<VertBoxes,256> blocks;
      CacheEntries<size_t,numGroups,15> keys;
      Groups groups; //!< in world space
    };

    /* --- moving blocks --- */

    /*! lane: 0 for blocks */
    struct SegmentKey
    {
      const void* block;
      uint32_t segment, lane;

      __forceinline bool operator== (const SegmentKey& other) const {
        return block == other.block && segment == other.segment && lane == other.lane;
      }
    };

    /*! Data of a step that groups share. */
    struct StepCells
    {
      alignas(64) uint16_t fields[16]; //!< offset in the step of each group's fields
      uint32_t words[16];              //!< word of each group's cell
      CellCoordinates corners;         //!< corners of the groups
    };

    /*! Data of a segment that groups share. Boxes are interpolated between its ends. */
    struct SegmentBoxes : public VertAxes
    {
      uint32_t lanes;            //!< mask of lanes with a group
      SegmentKey key;            //!< key of the block
      float origins[2][3];       //!< origins of the block, at both ends
      GroupPlanes ends[2][3];    //!< at both ends, by axis
      StepCells steps[2];        //!< at both ends; unused for a raw step
    };

    /*! Vertices of a group in world space, at the ends of a segment. */
    struct SegmentVertices
    {
      SegmentKey key;            //!< key of the group
      CellVertices ends[2];
    };

    /*! Cache of moving blocks. Boxes, Group: entries for a segment of a block and of one of its groups, with a
     *  SegmentKey. blockBytes, groupBytes: as for slotOfBlock. */
    template<typename Boxes, typename Group, size_t blockBytes, size_t groupBytes, size_t numBlocks, size_t numGroups>
    class SegmentEntries
    {
    public:
      /*! If the slot's key differs, the caller must fill the slot and set it. */
      __forceinline Boxes& slot (const void* block, uint32_t segment) {
        return blocks[blocks.slot(slotOfBlock(block,blockBytes) + segment)];
      }
      __forceinline Group& slot (const void* block, uint32_t segment, uint32_t lane) {
        return groups[groups.slot(slotOfBlock(block,groupBytes) + lane + 7*segment)];
      }

      void clear ()
      {
        for (size_t i=0; i<blocks.size(); i++) blocks[i].key.block = nullptr;
        for (size_t i=0; i<groups.size(); i++) groups[i].key.block = nullptr;
      }

    private:
      CacheEntries<Boxes,numBlocks> blocks;
      CacheEntries<Group,numGroups> groups;
    };

    /* An odd number of groups: blocks at equal distances, of a power of two, do not share a few entries. */
    typedef SegmentEntries<SegmentBoxes,SegmentVertices,512,32,160,323> MotionEntries;
    typedef ThreadCache<VertEntries> VertCache;
    typedef ThreadCache<MotionEntries> MotionCache;
    extern template class ThreadCache<VertEntries>;
    extern template class ThreadCache<MotionEntries>;
  }
}
