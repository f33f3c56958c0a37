// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Decoded mesh blocks (cvert/format/mesh_block.h) in the cache of a thread (base/thread_cache.h). As in cache.h, a
 * block's boxes and the triangles of each half group have separate entries. */

#include "../base/codec_names.h"
#include "../../cvert/format/mesh_block.h"
#include "cache.h"

namespace embree::cbvh {
/*! Entry of a block: the boxes of its groups, and where the groups' data begin. Group g is in lane g. */
struct MeshBlockEntry : public GroupBoxes {
  const void* block;                                   //!< block that the entry belongs to, or null
  uint32_t topologyBegin, verticesBegin, numbersBegin; //!< first bits of sections
  /* first bits of each group's data, from the start of the section */
  alignas(16) uint16_t topology[16];
  alignas(16) uint16_t numbers[16];
  /*! Index in the block of the first vertex that belongs to each group; 0x7FFF in lanes without a group. */
  alignas(16) uint16_t firstVertex[16];
  alignas(32) uint16_t fieldBitOfVertex0[16]; //!< see fieldBitOfVertex
  alignas(16) uint8_t fieldBits[4][16];       //!< bits of a vertex of each group: on x, y and z, and in total
  alignas(64) uint32_t lower[3][16];          //!< [axis][group]: coordinates to which vertex fields are relative

  /*! First bit in the block of vertex v, which belongs to group g. fieldBitOfVertex0: of vertex 0, if it belonged
   *  to the group, relative to verticesBegin, modulo 2^16. */
  __forceinline uint32_t fieldBitOfVertex(uint32_t v, uint32_t g) const {
    return verticesBegin + uint16_t(fieldBitOfVertex0[g] + v * fieldBits[3][g]);
  }
};

/*! World positions of a group's vertices: [axis][vertex]. Other lanes are undefined. */
struct alignas(64) MeshVertices {
  float at[3][32];
};

/*! Entry of half a group: up to 16 of its triangles, one per lane, and all vertices of the group. */
struct MeshTriangles {
  size_t key;       //!< keyOfHalf, or 0
  bool hasNextHalf; //!< this is the first half of a group with two
  uint16_t lanes;   //!< mask of lanes with a triangle
  uint8_t numVertices;
  alignas(16) uint8_t corners[3][16]; //!< [corner][lane]: vertex, below 32; in the application's order
  MeshVertices vertices;

  static const uint32_t width = 16;
};
/* 7: the vertices occupy 6. Every further cache line would cost 46 or 90 KiB per thread, see VertBlockEntry. */
static_assert(sizeof(MeshTriangles) == 7 * 64, "MeshTriangles must occupy exactly 7 cache lines");

/*! Key of a half in the cache. lane: group, plus 16 for the second half. Unique, because blocks have at least 32
 *  bytes. */
__forceinline size_t keyOfHalf(const void* block, uint32_t lane) { return size_t(block) + lane; }

class MeshEntries {
public:
  /*! As VertEntries::blockEntry. 1024: neighboring blocks of more bytes have different entries. */
  __forceinline MeshBlockEntry& blockEntry(const void* block) {
    return blocks[blocks.indexOf(localityHashOfBlock(block, 1024))];
  }

  /*! The 32 entries of a block's halves, in the order of keyOfHalf. If a key differs, the caller must decode the
   *  half into the entry and set the key. 64: neighboring blocks of 64 x 32 bytes or more share no entries. */
  __forceinline MeshTriangles* halves(const void* block) {
    return &triangles[triangles.indexOf(localityHashOfBlock(block, 64))];
  }

  void clear() {
    for (size_t i = 0; i < blocks.size(); i++) blocks[i].block = nullptr;
    for (size_t i = 0; i < triangles.size(); i++) triangles[i].key = 0;
  }

private:
  CacheEntries<MeshBlockEntry, 192> blocks;
  CacheEntries<MeshTriangles, 704, 31> triangles;
};

/* --- moving blocks --- */

/*! Where the vertex fields of a block are at a time step after the first (cvert/format/mesh_motion.h). */
struct MeshStepFields {
  const uint8_t* data;  //!< start of the step's fields
  uint16_t begin[16];   //!< first bit of each group's fields
  uint8_t bits[3][16];  //!< bits of a field: [axis][group]
  uint32_t base[3][16]; //!< added to each field: [axis][group]
};

/*! Entry of a block in a segment. [e]: 0 for the beginning and 1 for the end of the segment. `planes` are not
 *  sheared. */
struct MeshSegmentEntry {
  SegmentKey key;           //!< of the block
  float origins[2][3];      //!< [e][axis]
  float extent[3];          //!< as VertAxes::extent, at all times in the segment
  GroupPlanes planes[2][3]; //!< [e][axis]
  MeshStepFields steps[2];  //!< [e]; undefined for the block's first step
  MeshBlockEntry first;     //!< where groups begin in the block, and boxes at the first step
};

/*! Entry of half a group in a segment. */
struct SegmentTriangles {
  SegmentKey key;      //!< of the half; `lane` as in keyOfHalf
  MeshTriangles begin; //!< triangles, and vertices at the beginning of the segment; `key` is unused
  MeshVertices end;    //!< vertices at the end of the segment
};

typedef SegmentEntries<MeshSegmentEntry, SegmentTriangles, 2048, 128, 112, 256> MeshMotionEntries;
typedef ThreadCache<MeshEntries> MeshCache;
typedef ThreadCache<MeshMotionEntries> MeshMotionCache;
extern template class ThreadCache<MeshEntries>;
extern template class ThreadCache<MeshMotionEntries>;
} // namespace embree::cbvh
