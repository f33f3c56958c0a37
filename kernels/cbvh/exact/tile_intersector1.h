// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersector of tiles: boxes of all leaves, then triangles of one or two leaves at a time, front to back.
 * Candidates are found and tested by the same operations as in blocks (cvert/rule/rule.h), so that hits are equal. */

#include "intersector1.h"
#include "tile_block.h"

namespace embree::isa::cbvh {
/*! Leaves whose boxes a ray enters. Leaf (column, row) is bit column + 4 row of masks. */
class EnteredLeaves {
public:
  /*! Mask of leaves that the ray enters before tfar. */
  __forceinline uint32_t enteredBefore(float tfar) const {
    vboolV before[maxVectors];
    for (int j = 0; j < maxVectors; j++) before[j] = j < vectors ? enter[j] <= vfloatV(tfar) : vboolV(false);
    return movemasks(before);
  }

  uint32_t mask;

protected:
  __forceinline explicit EnteredLeaves(uint32_t region)
    : vectors(int(tileParts(region) * leavesPerPart) / vectorWidth) {}

  /*! distances(offset,axis,isFar): of the ray's entry into, or exit from, the planes at an offset in the boxes.
   *  isSafe: false if they could be NaN. */
  template<typename Distances>
  __forceinline void set(const VertRay& ray, uint32_t region, float tnear, float tfar, bool isSafe,
                         const Distances& distances) {
    if (unlikely(!isSafe)) {
      for (int j = 0; j < vectors; j++) enter[j] = vfloatV(tnear);
      mask = ~0u >> (32 - vectorWidth * vectors);
    } else {
      vboolV hit[maxVectors];
      for (int j = 0; j < maxVectors; j++) {
        hit[j] = vboolV(false);
        if (j >= vectors) continue;
        const uint32_t part =
            tilePartBytes * (uint32_t(j) * vectorWidth / leavesPerPart) + uint32_t(j) * vectorWidth % leavesPerPart;
        vfloatV from(tnear), to(tfar);
        for (uint32_t k = 0; k < 3; k++) {
          const uint32_t near = (ray.negativeAxes >> k) & 1u;
          from = max(from, distances(part + leavesPerPart * (2 * k + near), k, false));
          to = min(to, distances(part + leavesPerPart * (2 * k + 1 - near), k, true));
        }
        enter[j] = from;
        hit[j] = from <= to;
      }
      mask = movemasks(hit);
    }
    if (unlikely((region & 255u) != 255u)) mask &= tileLeaves(region);
  }

private:
  static const int maxVectors = 2 * int(leavesPerPart) / vectorWidth;

  const int vectors;
  vfloatV enter[maxVectors];
};

/*! Of a tile at rest. */
class LeafBoxes : public EnteredLeaves {
public:
  __forceinline LeafBoxes(const VertRay& ray, const VertHeader* tile, float tnear, float tfar)
    : EnteredLeaves(tile->region) {
    const uint8_t* const header = (const uint8_t*)tile;
    const vfloat4 spacing = withoutFourth(spacingsOfTile(tile)) * vfloat4(float(tileScale(tile))); // of steps
    const vfloat4 unit = vfloat4(vint4(extend8(loadFour(header + tileBoxStepOffset)))) * spacing;
    const vfloat4 rcp = vfloat4::load(ray.rcp),
                  distance = withoutFourth(vfloat4::loadu(tile->origin)) - vfloat4::load(ray.org);
    // planes are at most 255 steps of at most 255 spacings from the origin
    const vfloat4 largestSpacing = max(max(spacing, shuffle<1, 2, 0, 1>(spacing)), shuffle<2, 0, 1, 2>(spacing));
    const vfloat4 slack = vfloat4(tileSlackUlps * floatUlp) *
                          (abs(distance) + vfloat4(float((maxBoxByte + 1) * maxBoxByte)) * largestSpacing) * abs(rcp);
    const vfloat4 scale = unit * rcp, offset = distance * rcp;
    const vfloat4 nearOffset = offset - slack, farOffset = offset + slack;
    const uint8_t* const planes = header + tileBoxesOffset(tile->info);
    // products that overflow could be NaN
    const bool isSafe = all(vfloat4(float(maxBoxByte + 1)) * abs(scale) + abs(offset) + slack < vfloat4(1e37f));
    const vfloatV scales[3] = {broadcast<0>(scale), broadcast<1>(scale), broadcast<2>(scale)};
    const vfloatV nears[3] = {broadcast<0>(nearOffset), broadcast<1>(nearOffset), broadcast<2>(nearOffset)};
    const vfloatV fars[3] = {broadcast<0>(farOffset), broadcast<1>(farOffset), broadcast<2>(farOffset)};
    set(ray, tile->region, tnear, tfar, isSafe, [&](uint32_t offset, uint32_t k, bool isFar) {
      return madd(vfloatV(loadBytes(planes + offset)), scales[k], isFar ? fars[k] : nears[k]);
    });
  }
};

/*! Leaves that are still to be tested, roughly front to back. */
class LeafQueue {
public:
  /*! leaves: mask. flip: see leafFlip. Reverses rows by taking leaves from the end, which also reverses columns. Order
   *  within a pair of columns does not matter. */
  __forceinline LeafQueue(uint32_t leaves, uint32_t flip)
    : fromEnd((flip & 4u) != 0),
      swapsColumns(0u - ((flip ^ (flip >> 2)) & 1u)),
      rest(swapColumns(leaves)) {}

  __forceinline bool isEmpty() const { return rest == 0; }

  /*! Removes a leaf, and returns it. The queue must not be empty. */
  __forceinline uint32_t pop() {
    const uint32_t leaf = uint32_t(fromEnd ? bsr(rest) : bsf(rest));
    rest &= ~(1u << leaf);
    return leaf ^ (swapsColumns & 2u);
  }

  /*! Removes leaves that are not in a mask. */
  __forceinline void keep(uint32_t leaves) { rest &= swapColumns(leaves); }

private:
  __forceinline uint32_t swapColumns(uint32_t mask) const {
    const uint32_t swapped = ((mask & 0x33333333u) << 2) | ((mask >> 2) & 0x33333333u);
    return mask ^ ((mask ^ swapped) & swapsColumns);
  }

  const bool fromEnd;
  const uint32_t swapsColumns; //!< all bits, or 0
  uint32_t rest;
};

/*! Triangles of one or two leaves that a ray's line may pass through. */
class LeafTriangles {
public:
  uint32_t first, second; //!< bit 8 l + q: first or second triangle of quad q (column + 4 row) of leaf l

  /*! Tile: see TileIntersector1. */
  template<typename Tile>
  __forceinline LeafTriangles(const VertRay& ray, const Tile& tile, const uint32_t leaves[tileLeavesAtOnce]) {
    const int axes[3] = {ray.kx, ray.ky, ray.kz};
    tile.vertices(leaves, axes, vertices);
    const LeafVectors z = vertices[2] - ray.org[ray.kz];
    const LeafCorners cx((vertices[0] - ray.org[ray.kx]).shear(ray.sx, z)),
        cy((vertices[1] - ray.org[ray.ky]).shear(ray.sy, z));
    vboolV firsts[tileQuadVectors], seconds[tileQuadVectors];
    for (int j = 0; j < tileQuadVectors; j++) {
      sides[j] = QuadSides(cx.at[j], cy.at[j]);
      firsts[j] = sides[j].mayContainFirst();
      seconds[j] = sides[j].mayContainSecond();
    }
    first = movemasks(firsts);
    second = movemasks(seconds);
  }

private:
  friend class StoredLeafTriangles;

  LeafVectors vertices[3]; //!< on axes kx, ky and kz
  QuadSides sides[tileQuadVectors];
};

/*! The same in memory, for access to single triangles. One leaf at a time is a Cached of VertHitReporter. */
class StoredLeafTriangles {
public:
  static const bool isMesh = false; //!< see hits1.h

  __forceinline StoredLeafTriangles(const VertRay& ray, const LeafTriangles& triangles) {
    const int axes[3] = {ray.kx, ray.ky, ray.kz};
    for (int i = 0; i < 3; i++)
      for (int n = 0; n < LeafLayout::vectors; n++)
        vfloatV::store(vertices[axes[i]] + vectorWidth * n, triangles.vertices[i].at[n]);
    for (int j = 0; j < tileQuadVectors; j++) {
      const QuadSides& sides = triangles.sides[j];
      halves[0].set(j, sides.diag, sides.left, sides.bottom);
      halves[1].set(j, sides.right, sides.top, -sides.diag);
    }
  }

  uint32_t slot; //!< 1 for the second of two leaves

  /*! index: of the triangle in its group of 4 x 4 quads, as for blocks. */
  __forceinline VertTriangle triangle(uint32_t index) const {
    return VertTriangle(vertices, leafTriangleLanes.at[slot][index % LeafTriangleLanes::triangles]);
  }
  __forceinline TriangleSides<float> sides(uint32_t index) const {
    return halves[index & 1u].at(8 * slot + ((index >> 1) & 7u));
  }

private:
  alignas(64) float vertices[3][LeafLayout::vectors * vectorWidth]; //!< [axis][lane]
  SidesInLanes halves[2];                                           //!< of first and second triangles
};

__forceinline VertTriangle triangleOf(const StoredLeafTriangles& leaf, uint32_t, uint32_t index) {
  return leaf.triangle(index);
}

/*! Triangles of a leaf that VertHitReporter tests. */
struct LeafCandidates {
  const StoredLeafTriangles& leaf;
  uint32_t mask;

  __forceinline TriangleSides<float> sides(uint32_t index) const { return leaf.sides(index); }
};

/*! Tile: TileBlock or MovingTileBlock. Boxes: LeafBoxes or MovingLeafBoxes. */
template<typename RayType, typename Tile, typename Boxes>
class TileIntersector1 {
public:
  /*! Returns true if a hit was accepted. As VertIntersector1::intersect. */
  template<typename... At>
  static __forceinline bool intersect(RayType& ray, IntersectContext* context, VertRay& vertRay, const VertHeader* tile,
                                      const At&... at) {
    vertRay.set(ray);
    const Boxes boxes(vertRay, tile, ray.tnear(), ray.tfar, at...);
    return boxes.mask != 0 && TileIntersector1(ray, context, vertRay, tile, at...).run(boxes);
  }

private:
  static const bool isAnyHit = IsAnyHit<RayType>::value;

  template<typename... At>
  __forceinline TileIntersector1(RayType& ray, IntersectContext* context, const VertRay& vertRay,
                                 const VertHeader* header, const At&... at)
    : ray(ray),
      context(context),
      vertRay(vertRay),
      tile(header, at...) {}

  __forceinline bool run(const Boxes& boxes) {
    LeafQueue queue(boxes.mask, isAnyHit ? 0 : tile.flip(vertRay.negativeAxes & 7u));
    bool found = false;
    while (!queue.isEmpty()) {
      uint32_t leaves[2];
      leaves[0] = queue.pop();
      const bool areTwo = tileLeavesAtOnce == 2 && !queue.isEmpty();
      leaves[1] = areTwo ? queue.pop() : leaves[0];
      const LeafTriangles triangles(vertRay, tile, leaves);
      if ((triangles.first | triangles.second) == 0) continue;
      StoredLeafTriangles stored(vertRay, triangles);
      bool isHit = report(leaves[0], 0, stored, triangles.first & 255u, triangles.second & 255u);
      if (isAnyHit && isHit) return true;
      if (areTwo) isHit |= report(leaves[1], 1, stored, triangles.first >> 8, triangles.second >> 8);
      if (!isHit) continue;
      if (isAnyHit) return true;
      found = true;
      queue.keep(boxes.enteredBefore(ray.tfar));
    }
    return found;
  }

  /*! first, second: masks of the leaf's first and second triangles. */
  __forceinline bool report(uint32_t leaf, uint32_t slot, StoredLeafTriangles& stored, uint32_t first,
                            uint32_t second) {
    const uint32_t candidates = first | second << 16;
    if (candidates == 0) return false;
    const uint32_t lowest = uint32_t(bsf(candidates));
    const bool isSingle = (candidates & (candidates - 1)) == 0;
    const uint32_t mask = likely(isSingle) ? 1u << (2 * (lowest & 15u) + (lowest >> 4))
                                           : everySecondBit(first) | everySecondBit(second) << 1;
    stored.slot = slot;
    VertHitReporter<VertTarget1<RayType>, StoredLeafTriangles> hits(VertTarget1<RayType>{ray, context}, vertRay,
                                                                    vertRay.nearest, tile.tile, stored);
    return hits.report((leaf & 3u) | ((leaf >> 3) << 2), LeafCandidates{stored, mask << (leaf & 4u ? 16 : 0)});
  }

  RayType& ray;
  IntersectContext* const context;
  const VertRay& vertRay;
  const Tile tile;
};

/*! As intersectVert. */
template<typename RayType>
__noinline bool intersectTile(RayType& ray, IntersectContext* context, VertRay& vertRay, const VertHeader* tile) {
  return TileIntersector1<RayType, TileBlock, LeafBoxes>::intersect(ray, context, vertRay, tile);
}
} // namespace embree::isa::cbvh
