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
    /*! Vertices of a cell by axis, one per lane. The lanes after the last vertex are undefined. */
    struct alignas(64) CellVertices { float at[3][VertTables::lanes]; };

    /*! Vertices of a cell in coordinates of the block: x, y, z and 0 per lane. */
    struct alignas(16) CellCoordinates { uint16_t at[26][4]; };

    /*! Planes of the boxes of groups on one axis, in world space; on the sheared axis, relative to the origin of the
     *  block. Group (x,y) is in lane x + 4 y. Lanes without a group are undefined. */
    struct alignas(64) GroupPlanes { float at[2][16]; }; //!< lower, upper

    /*! The axes of a block's boxes: the world's axes, except that one may be sheared. */
    struct VertAxes
    {
      int axis;        //!< the sheared axis, or 3 if none is, as in raw blocks
      float origin[3]; //!< of the block
      float extent[3]; //!< upper bound of the block's extent from its origin
      float shear[3];  //!< sheared coordinate: sum of the world coordinates relative to the origin, times these factors
    };

    /*! Boxes of the groups of a block. */
    struct GroupBoxes : public VertAxes
    {
      uint32_t lanes;        //!< mask of the lanes that have a group
      GroupPlanes planes[3]; //!< by axis
    };

    /*! Data that the groups of a block share, and their boxes. For a raw block, only axes, lanes and planes are set. */
    struct VertBoxes : public GroupBoxes
    {
      uint32_t words[16];    //!< word of each group's cell
      uint16_t fields[16];   //!< fields of each group: offset in bytes from the start of the block
      CellCoordinates corners; //!< corners of groups
      const void* block;     //!< block that the boxes belong to
    };
    static_assert(sizeof(VertBoxes) == 12*64,"VertBoxes must occupy exactly 12 cache lines");

    /*! Key of the group in a lane of a block. It is unique because blocks are aligned to 16 bytes. */
    __forceinline size_t keyOfGroup (const void* block, uint32_t lane) { return size_t(block) + lane; }

    class VertEntries
    {
    public:
      /*! Returns the slot of a block. If its `block` differs, the caller must fill the slot and set `block`. */
      __forceinline VertBoxes& slot (const void* block) { return blocks[placeOfBlock(block,512) % numBlocks]; }

      /*! Returns the slot of a group. If its key differs, the caller must fill the slot and set the key. */
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
      /* Together less than 512 KiB, the second-level cache of a core: a larger cache would evict the scene from it. */
      static const size_t numBlocks = 256, numGroups = 768;

      VertBoxes blocks[numBlocks];
      size_t keys[numGroups];
      CellVertices groups[numGroups]; //!< in world space
    };

    /* --- moving blocks: segments, at both of their ends --- */

    /*! Key of a block in a segment, or of a group of the block. */
    struct SegmentKey
    {
      const void* block;
      uint32_t segment, lane;

      __forceinline bool operator== (const SegmentKey& other) const {
        return block == other.block && segment == other.segment && lane == other.lane;
      }
    };

    /*! Data of the cells of a step that all groups share. */
    struct StepCells
    {
      alignas(64) uint16_t fields[16]; //!< fields of each group: offset in bytes from the start of the step
      uint32_t words[16];              //!< word of each group's cell
      CellCoordinates corners;         //!< corners of groups
    };

    /*! Data that the groups of a block share in a segment, and their boxes at both of its ends. Boxes at a time in
     *  between are interpolated. */
    struct SegmentBoxes : public GroupBoxes
    {
      SegmentKey key;            //!< key of the block
      float origins[2][3];       //!< origin of the block at both ends
      GroupPlanes ends[2][3];    //!< planes at both ends, by axis; the planes of GroupBoxes are unused
      StepCells steps[2];        //!< steps at both ends; unused for a raw step
    };

    /*! Vertices of a group at the ends of a segment, in world space. */
    struct SegmentVertices
    {
      SegmentKey key;            //!< key of the group
      CellVertices ends[2];
    };

    class MotionEntries
    {
    public:
      /*! Returns the slot of a block or a group in a segment. If its key differs, the caller must fill the slot and set
       *  the key. */
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
