// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* CachedVertBlock for mesh blocks. Code shared with cVERT blocks accesses a mesh block as a VertHeader: `surface` and
 * `primID` have the same offsets in a MeshHeader, and `region`, which only orders hits at the same distance, is `bytes`
 * there. */

#include "../base/block_validity.h"
#include "hits1.h"
#include "mesh_corners.h"
#include "mesh_decoder.h"

namespace embree::isa::cbvh {
static_assert(offsetof(MeshHeader, surface) == offsetof(VertHeader, surface) &&
                  offsetof(MeshHeader, primID) == offsetof(VertHeader, primID),
              "surface and primID must have the same offsets in both headers");

/*! Primitive of a triangle, and (u,v) of a point in it. info: MeshHeader::info. number: see meshHasQuads. w1, w2:
 *  barycentric weights of the triangle's second and third corner. */
__forceinline SurfacePoint pointOfMesh(uint32_t info, uint32_t number, float w1, float w2) {
  const bool isSecond = isSecondOfQuad(info, number);
  SurfacePoint point;
  point.primID = primitiveOfMesh(info, number);
  point.u = isSecond ? 1.0f - w1 : w1;
  point.v = isSecond ? 1.0f - w2 : w2;
  return point;
}

class CachedMeshBlock {
public:
  static const bool isMesh = true; //!< see hits1.h

  template<typename RayOrRays>
  __forceinline CachedMeshBlock(const RayOrRays&, const VertHeader* block)
    : cache(MeshCache::ofThread()),
      block((const MeshHeader*)block),
      entry(cache.blockEntry(block)),
      halves(cache.halves(block)) {}

  __forceinline const GroupBoxes* decodedBoxes() const { return likely(entry.block == block) ? &entry : nullptr; }

  /*! Always true: a mesh block has only the bounds of its leaf, which the ray intersects. */
  __forceinline bool mayIntersect(const VertRayBase<float>&, float, float) const { return true; }

  __forceinline bool isValid() const { return cbvh::isBlockValid(block, MESH_BLOCK); }

  __forceinline const GroupBoxes& boxes() const {
    ensureDecoded();
    return entry;
  }

  /*! Returns triangles 16 half to 16 half + 15 of group g; decodes them if necessary. half: 0, or 1 if half 0 has
   *  hasNextHalf. */
  __forceinline const MeshTriangles& triangles(uint32_t g, uint32_t half) const {
    MeshTriangles& at = halves[16 * half + g];
    if (at.key != keyOfHalf(block, 16 * half + g)) decode(g, half, at);
    return at;
  }

  /*! Primitive and (u,v) of a hit in a triangle of group g. index: 0 to 31. w1, w2: see pointOfMesh. */
  __forceinline SurfacePoint point(uint32_t g, uint32_t index, float w1, float w2) const {
    ensureDecoded();
    return pointOfMesh(block->info, MeshDecoder(block).number(entry, g, index), w1, w2);
  }

private:
  __forceinline void ensureDecoded() const {
    if (unlikely(entry.block != block)) decode();
  }

  __noinline void decode() const {
    for (int line = 1; line < 16; line++) prefetchL1((const char*)block + 64 * line);
    entry.block = block;
    MeshDecoder(block).decode(entry);
  }

  __noinline void decode(uint32_t g, uint32_t half, MeshTriangles& at) const {
    ensureDecoded();
    at.key = keyOfHalf(block, 16 * half + g);
    MeshDecoder(block).triangles(entry, g, half, at);
  }

  MeshCache& cache;
  const MeshHeader* block;
  MeshBlockEntry& entry;
  MeshTriangles* const halves;
};
} // namespace embree::isa::cbvh
