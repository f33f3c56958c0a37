// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Searches blocks for triangles within the radius of a query, nearest boxes first. */

#include "decoded_mesh_tile.h"
#include "moving_mesh_block.h"
#include "near_triangles.h"
#include "tile_block.h"

namespace embree::isa::cbvh {
/*! Distances of the triangles of quads, one quad per lane. Bits of masks: quad, plus 16 for second triangles. */
template<int vectors>
class QuadDistances {
public:
  /*! Corners: at(j, c) returns corner c (column + 2 row) of the quads in vector j. */
  template<typename Corners>
  __forceinline QuadDistances(const Corners& x, const Corners& y, const Corners& z) {
    for (int j = 0; j < vectors; j++) {
      auto corner = [&](int c) { return OffsetsV(x.at(j, c), y.at(j, c), z.at(j, c)); };
      const OffsetsV c1 = corner(1), c2 = corner(2);
      triangles[0][j] = TriangleDistances(corner(0), c1, c2);
      triangles[1][j] = TriangleDistances(c2, c1, corner(3));
    }
  }

  __forceinline uint32_t mayBeWithin(float distance) const {
    vboolV within[2][vectors];
    for (int i = 0; i < 2; i++)
      for (int j = 0; j < vectors; j++) within[i][j] = triangles[i][j].mayBeWithin(distance);
    return movemasks(within[0]) | movemasks(within[1]) << 16;
  }

  void squared(float out[32]) const {
    for (int i = 0; i < 2; i++)
      for (int j = 0; j < vectors; j++) vfloatV::storeu(out + 16 * i + vectorWidth * j, triangles[i][j].squared);
  }

private:
  TriangleDistances triangles[2][vectors];
};

/*! Distances of the triangles of half a group of a mesh block. Bits of masks: lane. */
class MeshDistances {
public:
  __forceinline MeshDistances(const MeshTriangles& mesh, const float p[3]) : lanes(mesh.lanes) {
    alignas(64) float at[3][3][MeshTriangles::width]; // [corner][axis]
    for (int c = 0; c < 3; c++)
      for (int k = 0; k < 3; k++)
        for (uint32_t i = 0; i < MeshTriangles::width; i++)
          at[c][k][i] = mesh.vertices.at[k][mesh.corners[c][i] & 31u] - p[k];
    for (int j = 0; j < vectors; j++) {
      auto corner = [&](int c) {
        const int n = vectorWidth * j;
        return OffsetsV(vfloatV::load(at[c][0] + n), vfloatV::load(at[c][1] + n), vfloatV::load(at[c][2] + n));
      };
      triangles[j] = TriangleDistances(corner(0), corner(1), corner(2));
    }
  }

  __forceinline uint32_t mayBeWithin(float distance) const {
    vboolV within[vectors];
    for (int j = 0; j < vectors; j++) within[j] = triangles[j].mayBeWithin(distance);
    return movemasks(within) & lanes;
  }

  void squared(float out[32]) const {
    for (int j = 0; j < vectors; j++) vfloatV::storeu(out + vectorWidth * j, triangles[j].squared);
  }

private:
  static const int vectors = int(MeshTriangles::width) / vectorWidth;

  const uint32_t lanes;
  TriangleDistances triangles[vectors];
};

/*! Where a triangle is: its group, and its index there. See TriangleKey::triangle. */
struct TrianglePlace {
  uint32_t group, index;
};

/*! The primitives of a block: one of which the block is a part, its quads, or its triangles. */
enum class BlockPrimitives { ONE, QUADS, TRIANGLES };

/*! Visitor: what happens with triangles within the radius.
 *
 *    static const bool visitsQuads
 *      True if the first triangle of a quad that is a primitive is visited for both.
 *    double squaredRadius() const, float radius() const
 *      Of the query. radius: rounded up.
 *    bool isDone() const
 *      True to leave out the rest of the block.
 *    bool visit(primitives, block, place, triangleAt, pointAt)
 *      Called for a triangle that is probably within the radius. Returns true if the radius has decreased. block: a
 *      VertHeader, see cached_mesh.h. triangleAt(place): VertTriangle of this triangle, or of the other one of its
 *      quad. pointAt(sides): SurfacePoint in this triangle. */
template<typename Visitor>
class PointSearch {
public:
  __forceinline PointSearch(const PointQuery* query, Visitor& visitor)
    : p{query->p.x, query->p.y, query->p.z},
      time(query->time),
      visitor(visitor) {}

  void searchVert(const VertHeader* block) {
    if (isMoving(block->info)) {
      const VertMotion motion = motionOf(block);
      if (isPresent(motion, time)) searchQuads(block, MovingVertBlock(block, timeInMotion(motion, time)));
    } else {
      VertRay cacheOnly;
      cacheOnly.cache = &VertCache::ofThread();
      searchQuads(block, CachedVertBlock(cacheOnly, block));
    }
  }

  void searchMesh(const MeshHeader* mesh) {
    const VertHeader* const block = (const VertHeader*)mesh; // see cached_mesh.h
    const VertRay unused;
    if (isMovingMesh(mesh)) {
      const VertMotion motion = motionOfMesh(mesh);
      if (isPresent(motion, time)) searchTriangles(block, MovingMeshBlock(unused, block, timeInMotion(motion, time)));
    } else searchTriangles(block, CachedMeshBlock(unused, block));
  }

  void searchTile(const VertHeader* header) {
    if (isMeshTile(header)) return searchMeshTile((const MeshTileHeader*)header);
    if (!isMoving(header->info)) return searchTile(TileBlock(header), BoxDistances(p, header));
    const VertMotion motion = motionOf(header);
    if (!isPresent(motion, time)) return;
    const TimeInMotion at = timeInMotion(motion, time);
    searchTile(MovingTileBlock(header, at), BoxDistances(p, header, MovingLeafPlanes(header, at)));
  }

private:
  void searchMeshTile(const MeshTileHeader* tile) {
    const VertHeader* const block = (const VertHeader*)tile; // see cached_mesh.h
    if (!isMovingMeshTile(tile)) return searchTriangles(block, DecodedMeshTile(tile));
    const VertMotion motion = motionOfMeshTile(tile);
    if (isPresent(motion, time)) searchTriangles(block, DecodedMovingMeshTile(tile, timeInMotion(motion, time)));
  }

  /*! Tile: TileBlock or MovingTileBlock. */
  template<typename Tile>
  void searchTile(const Tile& tile, BoxDistances leaves) {
    uint32_t leaf[2] = {0, 0};
    while (!visitor.isDone() && leaves.popNearest(visitor.squaredRadius(), leaf[0])) {
      const bool areTwo = tileLeavesAtOnce == 2 && leaves.popNearest(visitor.squaredRadius(), leaf[1]);
      if (!areTwo) leaf[1] = leaf[0];
      searchLeaves(tile, leaf, areTwo);
    }
  }

  /*! Vertices of one or two leaves. */
  struct StoredLeaves {
    alignas(64) float at[3][LeafLayout::vectors * vectorWidth]; //!< [axis][lane]
  };

  /*! LeafCorners, as QuadDistances expects them. */
  struct LeafCornersAt {
    const LeafCorners corners;
    __forceinline vfloatV at(int j, int c) const { return corners.at[j][c]; }
  };

  template<typename Tile>
  void searchLeaves(const Tile& tile, const uint32_t leaf[2], bool areTwo) {
    const int axes[3] = {0, 1, 2};
    LeafVectors vertices[3];
    tile.vertices(leaf, axes, vertices);
    StoredLeaves stored;
    for (int k = 0; k < 3; k++)
      for (int n = 0; n < LeafLayout::vectors; n++) vfloatV::store(stored.at[k] + vectorWidth * n, vertices[k].at[n]);
    const QuadDistances<tileQuadVectors> distances(LeafCornersAt{LeafCorners(vertices[0] - p[0])},
                                                   LeafCornersAt{LeafCorners(vertices[1] - p[1])},
                                                   LeafCornersAt{LeafCorners(vertices[2] - p[2])});
    const VertHeader* const block = tile.tile;
    uint32_t existing = quadsOfLeaf(block->region, leaf[0]);
    if (areTwo) existing |= quadsOfLeaf(block->region, leaf[1]) << 8;
    test(
        distances, trianglesOf(block, existing), block, primitivesOf(block),
        [&](uint32_t bit) {
          const uint32_t l = leaf[(bit >> 3) & 1u];
          const uint32_t inLeaf = 2 * (bit & 7u) + (bit >> 4);
          return TrianglePlace{(l & 3u) | ((l >> 3) << 2), (l & 4u ? 16u : 0u) + inLeaf};
        },
        [&](TrianglePlace place, uint32_t bit) {
          return VertTriangle(stored.at, leafTriangleLanes.at[tileLeavesAtOnce == 2 ? (bit >> 3) & 1u : 0u]
                                                             [place.index % LeafTriangleLanes::triangles]);
        },
        [&](TrianglePlace place, const VertTriangle::Sides& sides) { return pointOfQuad(block, place, sides); });
  }

  template<typename Cached>
  void searchQuads(const VertHeader* block, const Cached& cached) {
    BoxDistances groups(p, cached.boxes());
    uint32_t g = 0;
    while (!visitor.isDone() && groups.popNearest(visitor.squaredRadius(), g)) {
      const CellVertices& vertices = cached.vertices(g);
      auto corners = [&](int k) {
        return QuadCornersV(CellVector(vertices.at[k]).map([&](const vfloatV& x) { return x - vfloatV(p[k]); }));
      };
      const QuadDistances<QuadCornersV::vectors> distances(corners(0), corners(1), corners(2));
      const uint32_t existing = quadsOfGroup(block->region, g);
      test(
          distances, trianglesOf(block, existing), block, primitivesOf(block),
          [&](uint32_t bit) { return TrianglePlace{g, 2 * (bit & 15u) + (bit >> 4)}; },
          [&](TrianglePlace place, uint32_t) { return VertTriangle(cached.vertices(place.group), place.index); },
          [&](TrianglePlace place, const VertTriangle::Sides& sides) { return pointOfQuad(block, place, sides); });
    }
  }

  template<typename Cached>
  void searchTriangles(const VertHeader* block, const Cached& cached) {
    BoxDistances groups(p, cached.boxes());
    uint32_t g = 0;
    while (!visitor.isDone() && groups.popNearest(visitor.squaredRadius(), g)) {
      const bool hasNextHalf = cached.triangles(g, 0).hasNextHalf;
      for (uint32_t half = 0; half < (hasNextHalf ? 2u : 1u); half++)
        test(
            MeshDistances(cached.triangles(g, half), p), ~0u, block, BlockPrimitives::TRIANGLES,
            [&](uint32_t bit) { return TrianglePlace{g, 16 * half + bit}; },
            [&](TrianglePlace place, uint32_t bit) { return triangleInLane(cached.triangles(place.group, half), bit); },
            [&](TrianglePlace place, const VertTriangle::Sides& sides) {
              return cached.point(place.group, place.index, clampParameter(sides.w1), clampParameter(sides.w2));
            });
    }
  }

  static __forceinline BlockPrimitives primitivesOf(const VertHeader* block) {
    return !hasPrimIDs(block->info)                 ? BlockPrimitives::ONE
           : isTriangleNumbering(block->patchQuads) ? BlockPrimitives::TRIANGLES
                                                    : BlockPrimitives::QUADS;
  }

  /*! Mask of the triangles of quads. */
  static __forceinline uint32_t trianglesOf(const VertHeader* block, uint32_t quads) {
    const bool haveOne = hasPrimIDs(block->info) && isSingleTriangleNumbering(block->patchQuads);
    return haveOne ? quads : quads | quads << 16;
  }

  static __forceinline SurfacePoint pointOfQuad(const VertHeader* block, TrianglePlace place,
                                                const VertTriangle::Sides& sides) {
    return surfacePoint(block, place.group, place.index, positionInQuad(sides, bool(place.index & 1u)));
  }

  /*! Mask of the quads of 4 x `rows` that exist, the first of which is (x,y) of the block. */
  static __forceinline uint32_t quadsFrom(uint32_t region, uint32_t x, uint32_t y, uint32_t rows) {
    const uint32_t columns = min(vertQuadsX(region) - x, groupQuads);
    return ((1u << columns) - 1u) * 0x1111u & ((1u << (4 * min(vertQuadsY(region) - y, rows))) - 1u);
  }
  static __forceinline uint32_t quadsOfGroup(uint32_t region, uint32_t g) {
    return quadsFrom(region, groupQuads * (g & 3u), groupQuads * (g >> 2), groupQuads);
  }
  static __forceinline uint32_t quadsOfLeaf(uint32_t region, uint32_t leaf) {
    return quadsFrom(region, leafQuadsX * (leaf & 3u), leafQuadsY * (leaf >> 2), leafQuadsY);
  }

  /*! Visits triangles of a mask, first the one that is probably the nearest. placeOf(bit), triangleAt(place, bit),
   *  pointAt(place, sides): see Visitor. */
  template<typename Distances, typename PlaceOf, typename TriangleAt, typename PointAt>
  __forceinline void test(const Distances& distances, uint32_t existing, const VertHeader* block,
                          BlockPrimitives primitives, const PlaceOf& placeOf, const TriangleAt& triangleAt,
                          const PointAt& pointAt) {
    auto within = [&] {
      const uint32_t mask = existing & distances.mayBeWithin(visitor.radius());
      return Visitor::visitsQuads && primitives == BlockPrimitives::QUADS ? (mask | mask >> 16) & 0xFFFFu : mask;
    };
    uint32_t mask = within();
    for (bool isFirst = true; mask != 0 && !visitor.isDone(); isFirst = false) {
      const uint32_t bit = isFirst && (mask & (mask - 1)) ? nearestOf(distances, mask) : uint32_t(bsf(mask));
      mask &= ~(1u << bit);
      const TrianglePlace place = placeOf(bit);
      if (visitor.visit(
              primitives, block, place,
              [&](TrianglePlace at) { return triangleAt(at, bit ^ ((at.index ^ place.index) & 1u) << 4); },
              [&](const VertTriangle::Sides& sides) { return pointAt(place, sides); }))
        mask &= within();
    }
  }

  template<typename Distances>
  static __forceinline uint32_t nearestOf(const Distances& distances, uint32_t mask) {
    alignas(64) float squared[32];
    distances.squared(squared);
    uint32_t nearest = uint32_t(bsf(mask));
    for (uint32_t rest = mask & (mask - 1); rest; rest &= rest - 1) {
      const uint32_t bit = uint32_t(bsf(rest));
      if (squared[bit] < squared[nearest]) nearest = bit;
    }
    return nearest;
  }

  const float p[3];
  const float time;
  Visitor& visitor;
};
} // namespace embree::isa::cbvh
