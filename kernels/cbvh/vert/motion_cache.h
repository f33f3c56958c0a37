// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What each thread keeps of blocks of cVERT that move: of segments, at both of their ends. */

#include "cache.h"

namespace embree
{
  namespace cbvh
  {
    /*! a block of a segment, or a group of it */
    struct SegmentKey
    {
      const void* block;
      uint32_t segment, lane;

      __forceinline bool operator== (const SegmentKey& other) const { return block == other.block && segment == other.segment && lane == other.lane; }
    };

    /*! a step's cells, as far as they are known once for all groups */
    struct StepCells
    {
      alignas(64) uint16_t fields[16]; //!< of each group: bytes from the step's start
      uint32_t words[16];              //!< of each group's cell
      CellCoordinates corners;         //!< of groups
    };

    /*! What a block's groups have in common in a segment, and their boxes at its ends: of a time between them all are between. */
    struct SegmentBoxes : public GroupBoxes
    {
      SegmentKey key;            //!< whose they are
      float origins[2][3];       //!< of the block, at the ends
      GroupPlanes ends[2][3];    //!< planes at the ends, by axis; those of GroupBoxes are not anything
      StepCells steps[2];        //!< of the ends; of a raw one not anything
    };

    /*! vertices of a group at the ends of a segment, in the world */
    struct SegmentVertices
    {
      SegmentKey key;            //!< whose they are
      CellVertices ends[2];
    };

    class MotionEntries
    {
    public:
      /*! The slot of a block (of a group) in a segment: what is there is the caller's if its key says so, else
       *  it is to be filled, and named. */
      __forceinline SegmentBoxes& slot (const void* block, uint32_t segment) { return blocks[(hashOfBlock(block) + segment) % numBlocks]; }
      __forceinline SegmentVertices& slot (const void* block, uint32_t segment, uint32_t lane) { return groups[(hashOfBlock(block)*5 + lane + 7*segment) % numGroups]; }

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

    typedef ThreadCache<MotionEntries> MotionCache;
  }
}
