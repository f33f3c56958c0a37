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
    /*! Vertices by axis, one per lane. Lanes after the last vertex are undefined. */
    struct alignas(64) CellVertices { float at[3][VertTables::lanes]; };

    /*! Vertices in coordinates of the block: x, y, z and 0 per lane. */
    struct alignas(16) CellCoordinates { uint16_t at[26][4]; };

    /*! Planes on one axis, in world space; on the sheared axis, relative to the origin of the block. Group (x,y) is in
     *  lane x + 4 y. Lanes without a group are undefined. */
    struct alignas(64) GroupPlanes { float at[2][16]; }; //!< lower, upper

    /*! world axes; one may be sheared */
    struct VertAxes
    {
      int axis;        //!< sheared axis, or 3 for none, as in raw blocks
      float origin[3]; //!< origin of the block
      float extent[3]; //!< at least the distance of vertices and planes from the origin
      float shear[3];  //!< factors of world coordinates, relative to the origin, in the sheared coordinate
    };

    struct GroupBoxes : public VertAxes
    {
      uint32_t lanes;        //!< mask of lanes with a group
      GroupPlanes planes[3]; //!< by axis
    };

    /*! Data that the groups of a block share. For a raw block, only axes, lanes and planes are set. */
    struct VertBoxes : public GroupBoxes
    {
      uint32_t words[16];    //!< word of each group's cell
      uint16_t fields[16];   //!< offset in the block of each group's fields
      CellCoordinates corners; //!< corners of the groups
      const void* block;     //!< that the boxes belong to
    };
    static_assert(sizeof(VertBoxes) == 12*64,"VertBoxes must occupy exactly 12 cache lines");

    /*! Unique because blocks are aligned to 16 bytes. */
    __forceinline size_t keyOfGroup (const void* block, uint32_t lane) { return size_t(block) + lane; }

    class VertEntries
    {
    public:
      /*! If the slot's `block` differs, the caller must fill the slot and set `block`. */
      __forceinline VertBoxes& slot (const void* block) { return blocks[slotOfBlock(block,512) % numBlocks]; }

      /*! If the slot's key differs, the caller must fill the slot and set the key. */
      static __forceinline size_t slot (const void* block, uint32_t lane) {
        return (slotOfBlock(block,32) + lane) % numGroups;
      }
      __forceinline size_t& key (size_t slot) { return keys[slot]; }
      __forceinline CellVertices& vertices (size_t slot) { return groups[slot]; }

      void clear ()
      {
        for (VertBoxes& block : blocks) block.block = nullptr;
        for (size_t& key : keys) key = 0;
      }

    private:
      /* Less than 512 KiB, the second-level cache of a core: a larger cache would evict the scene from it. */
      static const size_t numBlocks = 256, numGroups = 768;

      VertBoxes blocks[numBlocks];
      size_t keys[numGroups];
      CellVertices groups[numGroups]; //!< in world space
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

    /*! Data of a step that its groups share. */
    struct StepCells
    {
      alignas(64) uint16_t fields[16]; //!< offset in the step of each group's fields
      uint32_t words[16];              //!< word of each group's cell
      CellCoordinates corners;         //!< corners of the groups
    };

    /*! Data that the groups of a block share in a segment. Boxes are interpolated between its ends. */
    struct SegmentBoxes : public GroupBoxes
    {
      SegmentKey key;            //!< key of the block
      float origins[2][3];       //!< origins of the block at both ends
      GroupPlanes ends[2][3];    //!< planes at both ends, by axis; GroupBoxes::planes is unused
      StepCells steps[2];        //!< steps at both ends; unused for a raw step
    };

    /*! Vertices of a group in world space, at the ends of a segment. */
    struct SegmentVertices
    {
      SegmentKey key;            //!< key of the group
      CellVertices ends[2];
    };

    /*! Cache of moving blocks. Boxes, Group: entries for a segment of a block and for one of its groups, with a
     *  SegmentKey. blockBytes, groupBytes: as for slotOfBlock. */
    template<typename Boxes, typename Group, size_t blockBytes, size_t groupBytes, size_t numBlocks, size_t numGroups>
    class SegmentEntries
    {
    public:
      /*! If the slot's key differs, the caller must fill the slot and set the key. */
      __forceinline Boxes& slot (const void* block, uint32_t segment) {
        return blocks[(slotOfBlock(block,blockBytes) + segment) % numBlocks];
      }
      __forceinline Group& slot (const void* block, uint32_t segment, uint32_t lane) {
        return groups[(slotOfBlock(block,groupBytes) + lane + 7*segment) % numGroups];
      }

      void clear ()
      {
        for (Boxes& block : blocks) block.key.block = nullptr;
        for (Group& group : groups) group.key.block = nullptr;
      }

    private:
      Boxes blocks[numBlocks];
      Group groups[numGroups];
    };

    typedef SegmentEntries<SegmentBoxes,SegmentVertices,512,32,160,240> MotionEntries; // less than 512 KiB
    typedef ThreadCache<VertEntries> VertCache;
    typedef ThreadCache<MotionEntries> MotionCache;
  }
}
