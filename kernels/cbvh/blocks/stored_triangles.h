// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Reads the triangles of a surface as they are stored, for operations/stored_surface.h. Traversal has code of its own,
 * which computes the same floats. */

#include "block_table.h"
#include "part.h"
#include "../base/point_on_surface.h"
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <vector>

namespace embree {
struct SurfaceBlocks;

namespace cbvh {
/*! Time of rays. isFused: the device's intersectors interpolate vertices with fused multiply-adds. */
struct TraversalTime {
  float time;
  bool isFused;
};

/*! A block of cVERT or cGRID, a mesh block, or a tile. */
struct StoredBlock {
  const void* data;
  BlockType type;

  const VertHeader* vert() const { return (const VertHeader*)data; }
  const Block* framed() const { return (const Block*)data; }
  const MeshHeader* mesh() const { return (const MeshHeader*)data; }
  const MeshTileHeader* meshTile() const { return (const MeshTileHeader*)data; }

  bool isMeshTile() const { return type == TILE_BLOCK && cbvh::isMeshTile(data); }
  /*! `type`, but MESH_BLOCK for a mesh tile. */
  BlockType contents() const { return isMeshTile() ? MESH_BLOCK : type; }
  /*! MeshHeader::info of a mesh block or a mesh tile. */
  uint32_t meshInfo() const { return isMeshTile() ? meshTile()->meshInfo : mesh()->info; }

  uint32_t primID() const {
    uint32_t primID;
    memcpy(&primID, (const char*)data + rowOf(type).primID, sizeof(primID));
    return primID;
  }

  /*! True for cVERT blocks and tiles of quad or triangle meshes, where quads or their triangles are primitives. */
  bool areQuadsPrimitives() const {
    return (contents() == VERT_BLOCK || contents() == TILE_BLOCK) && hasPrimIDs(vert()->info);
  }
};

/*! Finds the triangle of a hit. Immutable, so threads may share it. */
class BlockIndex {
public:
  /*! Throws as forEachPart(). `blocks` must outlive the index. */
  explicit BlockIndex(const SurfaceBlocks& blocks);

  /*! See operations/stored_surface.h. */
  bool find(const TraversalTime& time, uint32_t primID, float u, float v, const float* Ng,
            StoredTriangle& triangle) const;

  /*! See core::findClosestPointOfPrimitive. */
  bool findClosest(const TraversalTime& time, uint32_t primID, const float p[3], float radius,
                   PointOnSurface& closest) const;

private:
  template<typename Closure> void forBlocksOf(uint32_t primID, const Closure& closure) const;

  enum : uint32_t { none = 0xFFFFFFFFu };

  std::vector<StoredBlock> blocks; //!< sorted by primitive
  std::vector<uint32_t> blockOf;   //!< by primitive of a mesh; otherwise empty
  /*! Sorted pairs of primitive and block, for quads with a triangle in a second mesh block, and for primitives with
   *  numbers too large for blockOf. */
  std::vector<std::pair<uint32_t, uint32_t>> otherBlocks;
};

/*! Calls closure(block, part) for all parts that exist at the time, until it returns false. A part is valid during
 *  its call. The triangles of a quad in different mesh blocks are parts of their own, as are triangles without a
 *  partner. Throws if a block is damaged, or a leaf is not cVERT, cGRID or a mesh block. */
void forEachPart(const SurfaceBlocks& blocks, const TraversalTime& time,
                 const std::function<bool(const StoredBlock&, const StoredPart&)>& closure);
} // namespace cbvh
} // namespace embree
