// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoded cVERT blocks in the cache of a thread (base/thread_cache.h). Blocks and groups have separate entries, because
 * each ray that reaches a block needs the groups' boxes, but few rays need a certain group's vertices. */

#include "../base/thread_cache.h"
#include "tables.h"

namespace embree
{
  namespace cbvh
  {
    /*! World positions or lattice coordinates of a cell's vertices: [axis][laneOfVertex]. Other lanes are undefined. */
    struct alignas(64) CellVertices { float at[3][VertTables::lanes]; };

    /*! Lattice coordinates of a cell's vertices: x, y, z and 0 per lane. 26 lanes, because the 25
     *  vertices are stored two at a time. */
    struct alignas(16) CellCoordinates { uint16_t at[26][4]; };

    /*! Lower and upper planes of the groups' boxes on one axis: world coordinates, or relative to the block's origin on
     *  the sheared axis. Group (x,y) is in lane x + 4 y. Other lanes are undefined. */
    struct alignas(64) GroupPlanes { float at[2][16]; };

    /*! Axes of a block's boxes: the world's axes, but one may be sheared. */
    struct VertAxes
    {
      int axis;        //!< the sheared axis; 3 for none, as in raw blocks
      float origin[3]; //!< of the block
      float extent[3]; //!< at least the distance of vertices and planes from the origin
      float shear[3];  //!< the sheared coordinate is the sum of shear[k]*(p[k]-origin[k])
    };

    struct GroupBoxes : public VertAxes
    {
      uint32_t lanes;        //!< mask of lanes with a group
      GroupPlanes planes[3]; //!< by axis
    };

    /*! Data of a block that its groups share. In a raw block, words, fields and corners are undefined. */
    struct VertBoxes : public GroupBoxes
    {
      uint32_t words[16];    //!< word of each group's cell
      uint16_t fields[16];   //!< offset of each group's fields in the block
      CellCoordinates corners; //!< corners of the groups
      const void* block;     //!< block that the boxes belong to, or null
    };
    static_assert(sizeof(VertBoxes) == 12*64,"VertBoxes must occupy exactly 12 cache lines");

    /*! Key of a group in the cache. Unique, because lane < 16 and blocks are aligned to 16 bytes. */
    __forceinline size_t keyOfGroup (const void* block, uint32_t lane) { return size_t(block) + lane; }

    class VertEntries
    {
    public:
      /*! If the slot's `block` differs, the caller must fill the slot and set `block`. 512: less than a full block, so
       *  that neighboring blocks have different slots. */
      __forceinline VertBoxes& slot (const void* block) { return blocks[blocks.slot(slotOfBlock(block,512))]; }

      /*! First of the 16 slots of a block's groups. If a slot's key differs, the caller must fill the slot and set its
       *  key. 32: 512 bytes per 16 groups. */
      static __forceinline size_t groupSlots (const void* block) { return Groups::slot(slotOfBlock(block,32)); }
      __forceinline size_t& key (size_t slot) { return keys[slot]; }
      __forceinline CellVertices& vertices (size_t slot) { return groups[slot]; }

      void clear ()
      {
        for (size_t i=0; i<blocks.size(); i++) blocks[i].block = nullptr;
        for (size_t i=0; i<keys.size(); i++) keys[i] = 0;
      }

    private:
      static const size_t numGroups = 768; //!< limited by a core's cache, see traversal/thread_cache.cpp
      typedef CacheEntries<CellVertices,numGroups,15> Groups;

      CacheEntries<VertBoxes,256> blocks;
      CacheEntries<size_t,numGroups,15> keys;
      Groups groups; //!< in world space
    };

    /* --- moving blocks --- */

    /*! Identifies a segment of a block, or of one of its groups. lane: lane of the group; 0 for the block. */
    struct SegmentKey
    {
      const void* block;
      uint32_t segment, lane;

      __forceinline bool operator== (const SegmentKey& other) const {
        return block == other.block && segment == other.segment && lane == other.lane;
      }
    };

    /*! Cells of a time step. */
    struct StepCells
    {
      alignas(64) uint16_t fields[16]; //!< offset of each group's fields from the start of the step
      uint32_t words[16];              //!< word of each group's cell
      CellCoordinates corners;         //!< corners of the groups
    };

    /*! Data of a segment that its groups share. VertAxes::origin is unused. */
    struct SegmentBoxes : public VertAxes
    {
      uint32_t lanes;            //!< mask of lanes with a group
      SegmentKey key;            //!< of the block
      float origins[2][3];       //!< by end
      GroupPlanes ends[2][3];    //!< by end and axis
      StepCells steps[2];        //!< undefined for a raw step
    };

    /*! Vertices of a group in world space, at the ends of a segment. */
    struct SegmentVertices
    {
      SegmentKey key;            //!< of the group
      CellVertices ends[2];
    };

    /*! Cache of moving blocks. Boxes, Group: entries for a segment of a block and of a group, with a SegmentKey `key`.
     *  blockBytes, groupBytes: arguments of slotOfBlock. */
    template<typename Boxes, typename Group, size_t blockBytes, size_t groupBytes, size_t numBlocks, size_t numGroups>
    class SegmentEntries
    {
    public:
      /*! If the slot's key differs, the caller must fill the slot and set its key. */
      __forceinline Boxes& slot (const void* block, uint32_t segment) {
        return blocks[blocks.slot(slotOfBlock(block,blockBytes) + segment)];
      }
      __forceinline Group& slot (const void* block, uint32_t segment, uint32_t lane) {
        // 7: segments of a group have different slots
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

    /* 323 is odd, so that blocks at distances of a power of two use all entries. */
    typedef SegmentEntries<SegmentBoxes,SegmentVertices,512,32,160,323> MotionEntries;
    typedef ThreadCache<VertEntries> VertCache;
    typedef ThreadCache<MotionEntries> MotionCache;
    extern template class ThreadCache<VertEntries>;
    extern template class ThreadCache<MotionEntries>;
  }
}
