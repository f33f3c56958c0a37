// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What threads keep of blocks of cVERT, thread_cache.h: 464 KiB each. */

#include "thread_cache.h"
#include "vert_tables.h"

namespace embree
{
  namespace cbvh
  {
    /*! vertices of a cell by axis, in a lane each */
    struct alignas(64) CellVertices { float at[3][VertTables::lanes]; };

    /*! corners of the 4 x 4 quads of a group: 00, 10, 01 and 11, each by axis, a quad in a lane */
    struct alignas(64) QuadCorners { float at[4][3][16]; };

    /*! Planes of groups' boxes on one axis, in the world, or, of the sheared one, from the block's origin;
     *  group (x,y) in lane x + 4 y. Lanes of no group are not anything. */
    struct alignas(64) GroupPlanes
    {
      float lower[16], upper[16];
      float extent; //!< of the block from its origin, at least
    };

    class VertEntries
    {
    public:
      struct Block
      {
        const void* block;     //!< whose it is
        CellVertices corners;  //!< of groups, in coordinates; not of a raw block
        GroupPlanes planes[3]; //!< by axis
      };

      struct Group
      {
        const void* block;     //!< whose it is
        uint32_t lane;
        QuadCorners quads;     //!< in the world
      };

      /*! The place of a block (of a group): what is there is the caller's if `block` (and lane) say so, else
       *  it is to be filled, and named. */
      __forceinline Block& place (const void* block) { return blocks[hashOfBlock(block) % numBlocks]; }
      __forceinline Group& place (const void* block, uint32_t lane) { return groups[(hashOfBlock(block)*5 + lane) % numGroups]; }

      void clear ()
      {
        for (Block& block : blocks) block.block = nullptr;
        for (Group& group : groups) group.block = nullptr;
      }

    private:
      static const size_t numBlocks = 256, numGroups = 256;

      Block blocks[numBlocks];
      Group groups[numGroups];
    };

    typedef ThreadCache<VertEntries> VertCache;
  }
}
