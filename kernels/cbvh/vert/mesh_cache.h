// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoded mesh blocks in a thread's cache (thread_cache.h). */

#include "../base/codec.h"
#include "../../cvert/format/mesh_block.h"
#include "cache.h"

namespace embree
{
  namespace cbvh
  {
    /*! Group g is in lane g. */
    struct MeshBoxes : public GroupBoxes
    {
      const void* block;             //!< block that the boxes belong to, or null
      uint32_t topologyBegin, verticesBegin, numbersBegin; //!< first bits in the block
      /* first bits in the sections, by group */
      alignas(16) uint16_t topology[16];
      alignas(16) uint16_t numbers[16];
      alignas(16) uint16_t firstVertex[16]; //!< by group; 0x7FFF in lanes without a group
      alignas(32) uint16_t fieldsOfZero[16]; //!< see fieldsOfVertex
      alignas(16) uint8_t fieldBits[4][16]; //!< bits per vertex of the group: on x, y and z, and in total
      alignas(64) uint32_t lower[3][16];    //!< coordinates to which fields are relative, by axis

      /*! First bit of vertex v of the block, which belongs to group g. */
      __forceinline uint32_t fieldsOfVertex (uint32_t v, uint32_t g) const {
        return verticesBegin + uint16_t(fieldsOfZero[g] + v*fieldBits[3][g]);
      }
    };

    /*! By axis. Lanes after the last vertex are undefined. */
    struct alignas(64) MeshVertices { float at[3][32]; };

    /*! Up to 16 triangles of a group, one per lane, and the group's vertices. Half h contains triangles from 16 h
     *  on. */
    struct MeshTriangles
    {
      size_t key;                       //!< keyOfHalf, or 0
      bool isFirstOfTwo;                //!< the group has a second half
      uint16_t lanes;                   //!< mask of lanes with a triangle
      uint8_t numVertices;
      alignas(16) uint8_t corners[3][16]; //!< vertices by corner, in the application's order; below 32 in all lanes
      MeshVertices vertices;

      static const uint32_t width = 16;
    };
    static_assert(sizeof(MeshTriangles) == 7*64,"MeshTriangles must occupy exactly 7 cache lines");

    /*! half: number of the group, plus 16 for the second half. Unique because blocks have at least 32 bytes. */
    __forceinline size_t keyOfHalf (const void* block, uint32_t half) { return size_t(block) + half; }

    class MeshEntries
    {
    public:
      /*! If the slot's `block` differs, the caller must fill the slot. */
      __forceinline MeshBoxes& slot (const void* block) { return blocks[blocks.slot(slotOfBlock(block,1024))]; }

      /*! The 32 slots of a block's halves of groups; see keyOfHalf. If a key differs, the caller must fill the slot. */
      __forceinline MeshTriangles* halves (const void* block) { return &groups[groups.slot(slotOfBlock(block,64))]; }

      void clear ()
      {
        for (size_t i=0; i<blocks.size(); i++) blocks[i].block = nullptr;
        for (size_t i=0; i<groups.size(); i++) groups[i].key = 0;
      }

    private:
      CacheEntries<MeshBoxes,192> blocks;
      CacheEntries<MeshTriangles,704,31> groups;
    };

    /* --- moving blocks --- */

    /*! Fields of groups in a step after the first. */
    struct MeshStepFields
    {
      const uint8_t* data;        //!< start of the step's fields
      uint16_t begin[16];         //!< first bit of each group's fields
      uint8_t bits[3][16];        //!< bits of a field, by axis and group
      uint32_t base[3][16];       //!< bases of fields, by axis and group
    };

    /*! Data of a segment that groups share. Boxes are interpolated between its ends. No axis is sheared. */
    struct SegmentMeshBoxes
    {
      SegmentKey key;            //!< key of the block
      float origins[2][3];       //!< see VertAxes; at both ends and between them
      float extent[3];           //!< of the block, at both ends
      GroupPlanes ends[2][3];    //!< at both ends, by axis
      MeshStepFields steps[2];   //!< at both ends; unused for the first step
      MeshBoxes first;           //!< positions of groups in the block, and boxes at the first step
    };

    /*! Half a group, at the ends of a segment. */
    struct SegmentTriangles
    {
      SegmentKey key;            //!< key of the half; lane: as the half of keyOfHalf
      MeshTriangles begin;
      MeshVertices end;
    };

    typedef SegmentEntries<SegmentMeshBoxes,SegmentTriangles,2048,128,112,256> MeshMotionEntries;
    typedef ThreadCache<MeshEntries> MeshCache;
    typedef ThreadCache<MeshMotionEntries> MeshMotionCache;
    extern template class ThreadCache<MeshEntries>;
    extern template class ThreadCache<MeshMotionEntries>;
  }
}
