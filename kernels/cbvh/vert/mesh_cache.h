// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoded mesh blocks in the cache of a thread (thread_cache.h): boxes per block, triangles per group. */

#include "../base/codec.h"
#include "../../cvert/format/mesh_block.h"
#include "cache.h"

namespace embree
{
  namespace cbvh
  {
    /*! Boxes of the groups of a mesh block, and the positions of the groups in the block. Group g is in lane g. */
    struct MeshBoxes : public GroupBoxes
    {
      const void* block;             //!< block that the boxes belong to, or null
      uint32_t topologyBegin, verticesBegin, numbersBegin; //!< first bits of sections, from the start of the block
      alignas(16) uint16_t topology[16];    //!< first bit of a group's topology, from the start of the section
      alignas(16) uint16_t vertices[16];    //!< first bit of the fields of a group's vertices, from the start of the
                                            //!< section
      alignas(16) uint16_t numbers[16];     //!< first bit of a group's primitive numbers, from the start of the section
      alignas(16) uint16_t firstVertex[16]; //!< first vertex of a group; above 0x7000 in lanes without a group
      /*! Number of bits of a vertex that belongs to the group. Bits 0..7: x, 8..15: y, 16..23: z, 24..31: sum. */
      alignas(16) uint32_t fieldBits[16];
      alignas(64) uint32_t lower[3][16];    //!< coordinates at which the fields of a group begin, by axis
    };

    /*! The triangles of a group of a mesh block, and the vertices that they use. */
    struct MeshTriangles
    {
      const void* block;             //!< block that the group belongs to, or null
      uint32_t lane;
      uint32_t numVertices;
      uint32_t lanes;                //!< mask of the lanes that have a triangle
      alignas(64) float at[3][32];   //!< vertices, by axis
      alignas(32) uint8_t corners[3][maxGroupTriangles]; //!< corners of the triangle in a lane, in the application's
                                                         //!< order
    };

    class MeshEntries
    {
    public:
      /*! Returns the slot of a block or a group. If its `block` (and `lane`) differ, the caller must fill the slot. */
      __forceinline MeshBoxes& slot (const void* block) { return blocks[placeOfBlock(block,1024) % numBlocks]; }
      __forceinline MeshTriangles& slot (const void* block, uint32_t lane) {
        return groups[(placeOfBlock(block,64) + lane) % numGroups];
      }

      void clear ()
      {
        for (MeshBoxes& block : blocks) block.block = nullptr;
        for (MeshTriangles& group : groups) group.block = nullptr;
      }

    private:
      /* Together less than 512 KiB, the second-level cache of a core: a larger cache would evict the scene from it. */
      static const size_t numBlocks = 256, numGroups = 480;

      MeshBoxes blocks[numBlocks];
      MeshTriangles groups[numGroups];
    };

    typedef ThreadCache<MeshEntries> MeshCache;
  }
}
