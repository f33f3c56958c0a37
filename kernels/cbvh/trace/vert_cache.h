// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* What a thread has decoded of blocks of cVERT lately. Rays that follow each other, of a picture or a
 * packet, mostly meet the blocks and the groups that the last ones met; decoding them is two thirds of
 * what a ray costs.
 *
 * Entries are found by the address of a block, in one place each. A block that is built may come to lie
 * where another was: a build makes all that threads keep outdated before it begins. */

#include "vert_tables.h"
#include "../../../common/sys/platform.h"
#include <atomic>
#include <cstddef>

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

    class VertCache
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

      /*! the calling thread's, without what is outdated */
      static __forceinline VertCache& ofThread ()
      {
        VertCache* cache = current;
        const unsigned now = generation.load(std::memory_order_relaxed);
        return cache != nullptr && cache->made == now ? *cache : renew(now);
      }

      /*! comes before blocks are built */
      static __forceinline void outdate () { generation.fetch_add(1); }

      /*! The place of a block (of a group): what is there is the caller's if `block` (and lane) say so, else
       *  it is to be filled, and named. */
      __forceinline Block& place (const void* block) { return blocks[hash(block) % numBlocks]; }
      __forceinline Group& place (const void* block, uint32_t lane) { return groups[(hash(block)*5 + lane) % numGroups]; }

    private:
      static const size_t numBlocks = 32, numGroups = 256;

      static __forceinline size_t hash (const void* block) { return size_t(block)/16*0x9E3779B1u >> 16; }
      static VertCache& renew (unsigned now);

      Block blocks[numBlocks];
      Group groups[numGroups];
      unsigned made; //!< generation

      static std::atomic<unsigned> generation;
      static __thread VertCache* current __attribute__((tls_model("initial-exec")));
    };
  }
}
