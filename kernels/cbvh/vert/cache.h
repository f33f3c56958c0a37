// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What each thread keeps of blocks of cVERT (thread_cache.h). */

#include "../base/thread_cache.h"
#include "tables.h"

namespace embree
{
  namespace cbvh
  {
    /*! vertices of a cell by axis, in a lane each; the lanes after the last vertex are undefined */
    struct alignas(64) CellVertices { float at[3][VertTables::lanes]; };

    /*! the same in coordinates: x, y and z of a lane, and 0 */
    struct alignas(16) CellCoordinates { uint16_t at[26][4]; };

    /*! Planes of groups' boxes on one axis, in the world, or, of the sheared one, from the block's origin;
     *  group (x,y) in lane x + 4 y. Lanes without a group are undefined. */
    struct alignas(64) GroupPlanes { float at[2][16]; }; //!< lower, upper

    /*! the axes of a block's boxes: those of the world, but that one may be sheared */
    struct VertAxes
    {
      int axis;        //!< that is sheared, or 3, as of a raw block
      float origin[3]; //!< of the block
      float extent[3]; //!< of the block from its origin, at least
      float shear[3];  //!< the sheared coordinate is the sum of the world's from the origin times these
    };

    /*! boxes of a block's groups */
    struct GroupBoxes : public VertAxes
    {
      uint32_t lanes;        //!< that have a group, as a mask
      GroupPlanes planes[3]; //!< by axis
    };

    /*! What a block's groups have in common, and their boxes. A raw block only has axes, lanes and planes. */
    struct VertBoxes : public GroupBoxes
    {
      uint32_t words[16];    //!< of each group's cell
      uint16_t fields[16];   //!< of each group: bytes from the block's start
      CellCoordinates corners; //!< of groups
      const void* block;     //!< that the boxes belong to
    };
    static_assert(sizeof(VertBoxes) == 12*64,"a slot takes more lines of memory");

    /*! a group of a block as one number: blocks lie at multiples of 16 bytes */
    __forceinline size_t keyOfGroup (const void* block, uint32_t lane) { return size_t(block) + lane; }

    class VertEntries
    {
    public:
      /*! The slot of a block: what is there is the caller's if `block` says so, else it is to be filled, and named. */
      __forceinline VertBoxes& slot (const void* block) { return blocks[placeOfBlock(block,512) % numBlocks]; }

      /*! The slot of a group: what is there is the caller's if its key says so, else it is to be filled, and named. */
      static __forceinline size_t slot (const void* block, uint32_t lane) {
        return (placeOfBlock(block,32) + lane) % numGroups;
      }
      __forceinline size_t& key (size_t slot) { return keys[slot]; }
      __forceinline CellVertices& vertices (size_t slot) { return groups[slot]; }

      void clear ()
      {
        for (VertBoxes& block : blocks) block.block = nullptr;
        for (size_t& key : keys) key = 0;
      }

    private:
      /* Together less than 512 KiB, the second-level cache of a core: more would take it from what is traced. */
      static const size_t numBlocks = 256, numGroups = 768;

      VertBoxes blocks[numBlocks];
      size_t keys[numGroups];
      CellVertices groups[numGroups]; //!< in the world
    };

    /* --- blocks that move: segments, at both of their ends --- */

    /*! a block of a segment, or a group of it */
    struct SegmentKey
    {
      const void* block;
      uint32_t segment, lane;

      __forceinline bool operator== (const SegmentKey& other) const {
        return block == other.block && segment == other.segment && lane == other.lane;
      }
    };

    /*! a step's cells, as far as they are known once for all groups */
    struct StepCells
    {
      alignas(64) uint16_t fields[16]; //!< of each group: bytes from the step's start
      uint32_t words[16];              //!< of each group's cell
      CellCoordinates corners;         //!< of groups
    };

    /*! What the groups of a block have in common in a segment, and their boxes at both of its ends. At a time in
     *  between, boxes are in between. */
    struct SegmentBoxes : public GroupBoxes
    {
      SegmentKey key;            //!< of the block
      float origins[2][3];       //!< of the block, at the ends
      GroupPlanes ends[2][3];    //!< planes at the ends, by axis; the planes of GroupBoxes are not used
      StepCells steps[2];        //!< of the ends; not used for a raw step
    };

    /*! vertices of a group at the ends of a segment, in the world */
    struct SegmentVertices
    {
      SegmentKey key;            //!< of the group
      CellVertices ends[2];
    };

    class MotionEntries
    {
    public:
      /*! The slot of a block (of a group) in a segment: what is there is the caller's if its key says so, else
       *  it is to be filled, and named. */
      __forceinline SegmentBoxes& slot (const void* block, uint32_t segment) {
        return blocks[(placeOfBlock(block,512) + segment) % numBlocks];
      }
      __forceinline SegmentVertices& slot (const void* block, uint32_t segment, uint32_t lane) {
        return groups[(placeOfBlock(block,32) + lane + 7*segment) % numGroups];
      }

      void clear ()
      {
        for (SegmentBoxes& block : blocks) block.key.block = nullptr;
        for (SegmentVertices& group : groups) group.key.block = nullptr;
      }

    private:
      static const size_t numBlocks = 256, numGroups = 256;

      SegmentBoxes blocks[numBlocks];
      SegmentVertices groups[numGroups];
    };

    typedef ThreadCache<VertEntries> VertCache;
    typedef ThreadCache<MotionEntries> MotionCache;
  }
}
