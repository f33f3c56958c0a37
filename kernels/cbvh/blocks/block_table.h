// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Properties of blocks by type, for building, files and back ends. Rays, packets and point queries have switches of
 * their own (traversal/intersector1.cpp, intersectorK.cpp, point_query.cpp), as have triangles (stored_triangles.cpp)
 * and validation (cvert/file/record.h). */

#include "../paper/block.h"
#include "../base/codec_names.h"
#include "../base/leaf_type.h"
#include "../base/reference.h"
#include "../base/thread_cache.h"
#include "../../cvert/format/mesh_motion.h"
#include "../../cvert/format/mesh_tile.h"
#include <cassert>

namespace embree::cbvh { inline namespace CBVH_ISA {
/*! Row of a type. Functions get the header of a valid block. The constructor has no defaults, so that no row can leave
 *  out a column. */
struct BlockRow {
  uint32_t surface; //!< offset of the surface number (base/surface_ids.h) in a block, in bytes
  uint32_t primID;  //!< offset of the (first) primitive
  unsigned cache;   //!< ThreadCaches of rays through blocks at rest
  unsigned movingCache;
  uint32_t (*bytes)(const void* block);         //!< size, without the bytes after it that decoders may read
  bool (*moves)(const void* block);             //!< true if it has time steps
  VertMotion (*motion)(const void* block);      //!< steps of a moving block
  bool (*hasFloats)(const void* block);         //!< false if its vertices are points of a lattice, unless it moves
  uint32_t (*referenceType)(const void* block); //!< for back ends (base/reference.h); numReferenceTypes if they lack it

  constexpr BlockRow(uint32_t surface, uint32_t primID, unsigned cache, unsigned movingCache,
                     uint32_t (*bytes)(const void*), bool (*moves)(const void*), VertMotion (*motion)(const void*),
                     bool (*hasFloats)(const void*), uint32_t (*referenceType)(const void*))
    : surface(surface),
      primID(primID),
      cache(cache),
      movingCache(movingCache),
      bytes(bytes),
      moves(moves),
      motion(motion),
      hasFloats(hasFloats),
      referenceType(referenceType) {}
};

inline BlockRow rowOf(BlockType type) {
  switch (type) {
  case FRAMED_BLOCK:
    return BlockRow(
        offsetof(BlockHeader, surface), offsetof(BlockHeader, primID), nodeCache, 0,
        [](const void* block) { return uint32_t(((const Block*)block)->layout().bytes); },
        [](const void*) { return false; }, [](const void*) { return VertMotion(); }, [](const void*) { return true; },
        [](const void* block) { return blockReferenceType(kindOf(((const BlockHeader*)block)->info)); });
  case VERT_BLOCK:
    return BlockRow(
        offsetof(VertHeader, surface), offsetof(VertHeader, primID), vertCache, motionCache,
        [](const void* block) { return vertBytes((const VertHeader*)block); },
        [](const void* block) { return isMoving(((const VertHeader*)block)->info); },
        [](const void* block) { return motionOf((const VertHeader*)block); },
        [](const void* block) {
          return isRaw(((const VertHeader*)block)->info) || hasRemainders(((const VertHeader*)block)->info);
        },
        [](const void* block) {
          return isMoving(((const VertHeader*)block)->info) ? movingBlockReferenceType : blockReferenceType(kindVert);
        });
  case TILE_BLOCK:
    return BlockRow(
        offsetof(VertHeader, surface), offsetof(VertHeader, primID), vertCache, vertCache,
        [](const void* tile) {
          return isMeshTile(tile) ? ((const MeshTileHeader*)tile)->bytes : tileBytes((const VertHeader*)tile);
        },
        [](const void* tile) {
          return isMeshTile(tile) ? isMovingMeshTile((const MeshTileHeader*)tile)
                                  : isMoving(((const VertHeader*)tile)->info);
        },
        [](const void* tile) {
          return isMeshTile(tile) ? motionOfMeshTile((const MeshTileHeader*)tile) : motionOf((const VertHeader*)tile);
        },
        [](const void* tile) {
          return !isMeshTile(tile) && tileVertexBytes((const VertHeader*)tile) == tileFloatBytes;
        },
        [](const void* tile) { // back ends decode moving blocks and mesh blocks, see flat_scene.cpp
          if (isMeshTile(tile))
            return isMovingMeshTile((const MeshTileHeader*)tile) ? numReferenceTypes : meshBlockReferenceType;
          return isMoving(((const VertHeader*)tile)->info) ? movingBlockReferenceType : blockReferenceType(kindTile);
        });
  case MESH_BLOCK:
    return BlockRow(
        offsetof(MeshHeader, surface), offsetof(MeshHeader, primID), meshCache, meshMotionCache,
        [](const void* block) { return ((const MeshHeader*)block)->bytes; },
        [](const void* block) { return isMovingMesh((const MeshHeader*)block); },
        [](const void* block) { return motionOfMesh((const MeshHeader*)block); },
        [](const void* block) { return hasRanksOnAnyAxis(((const MeshHeader*)block)->spacings); },
        [](const void* block) {
          return isMovingMesh((const MeshHeader*)block) ? numReferenceTypes : meshBlockReferenceType;
        });
  }
  assert(false);
  return rowOf(VERT_BLOCK);
}
}} // namespace embree::cbvh::CBVH_ISA
