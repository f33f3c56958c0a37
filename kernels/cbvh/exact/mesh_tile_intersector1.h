// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersector of mesh tiles: boxes of all groups, then groups, front to back for closest hits. Candidates
 * are found and tested by the same operations as in mesh blocks (cvert/rule/rule.h), so that hits are equal. */

#include "intersector1.h"
#include "mesh_tile_block.h"
#include "tile_intersector1.h"

namespace embree::isa::cbvh {
/*! Bound of the rounding errors on the sheared axis, as shearedSlackUlps. Distances to planes are computed as in tiles,
 *  see tileSlackUlps. */
static constexpr float meshTileShearedSlackUlps = shearedSlackUlps + (tileSlackUlps - slackUlps);

/*! Groups of a mesh tile whose boxes a ray enters. */
class EnteredGroups {
public:
  uint32_t mask;               //!< of groups
  alignas(64) float enter[16]; //!< lower bound of the entry distance, by group

protected:
  /*! negativeAxes: bit k is set if a ray enters boxes through the upper planes on axis k.
   * distances(plane,j,axis,isFar): of the ray's entry into, or exit from, an array of planes (meshTilePlanes). isSafe:
   * false if they could be NaN. */
  template<typename Distances>
  __forceinline void set(uint32_t groups, float tnear, float tfar, uint32_t negativeAxes, bool isSafe,
                         const Distances& distances) {
    const uint32_t lanes = (1u << groups) - 1u;
    if (unlikely(!isSafe)) {
      for (float& at : enter) at = tnear;
      mask = lanes;
      return;
    }
    vboolV hit[16 / vectorWidth];
    for (int j = 0; j < 16 / vectorWidth; j++) {
      vfloatV from(tnear), to(tfar);
      for (uint32_t k = 0; k < 3; k++) {
        const uint32_t negative = (negativeAxes >> k) & 1u;
        from = max(from, distances(k + 3 * negative, j, k, false));
        to = min(to, distances(k + 3 * (1 - negative), j, k, true));
      }
      vfloatV::store(enter + vectorWidth * j, from);
      hit[j] = from <= to;
    }
    mask = movemasks(hit) & lanes;
  }
};

/*! Of a mesh tile at rest. */
class MeshTileBoxes : public EnteredGroups {
public:
  __forceinline MeshTileBoxes(const VertRay& ray, const MeshTileHeader* tile, float tnear, float tfar) {
    const uint32_t groups = meshGroups(tile->counts), info = tile->meshInfo;
    const vint4 exponents(extend8(_mm_cvtsi32_si128(int(tile->spacings)))),
        shifts(int(info & 15u), int((info >> 4) & 15u), int((info >> 8) & 15u), 0);
    const vfloat4 unit = withoutFourth(asFloat((exponents + shifts) << 23));
    vfloat4 rcp = vfloat4::load(ray.rcp),
            distance = withoutFourth(vfloat4::loadu(tile->origin)) - vfloat4::load(ray.org);
    const vfloat4 farthest = abs(distance) + vfloat4(256.0f) * unit;
    vfloat4 slack = vfloat4(tileSlackUlps * floatUlp) * farthest * abs(rcp);
    if (unlikely((info & 0x03FF0000u) != 0)) {
      const vfloat4 shear = withoutFourth(vfloat4::loadu(tile->shear));
      vfloat4 x, y, z;
      transpose(shear * distance, shear * vfloat4::load(ray.dir), abs(shear) * farthest, vfloat4(zero), x, y, z);
      alignas(16) float along[4]; // from the ray to the tile's origin, of the direction, and of errors
      vfloat4::store(along, x + y + z);
      const float reciprocal = directionReciprocal(along[1], ray.largestComponent);
      const uint32_t m = meshShearedAxis(info);
      const float error = meshTileShearedSlackUlps * floatUlp * along[2] + 0.5f * meshSpacing(tile->spacings, m);
      const vboolf4 isAxis = vint4(int(m)) == vint4(0, 1, 2, 3);
      rcp = select(isAxis, vfloat4(reciprocal), rcp);
      distance = select(isAxis, vfloat4(along[0]), distance);
      slack = select(isAxis, vfloat4(error * std::fabs(reciprocal)), slack);
    }
    const vfloat4 scale = unit * rcp, offset = distance * rcp;
    // products that overflow could be NaN
    const bool isSafe = all(vfloat4(257.0f) * abs(scale) + abs(offset) + slack < vfloat4(1e37f));
    const vboolf4 isNegative = rcp < vfloat4(zero);
    const uint32_t negativeAxes = uint32_t(movemask(isNegative));
    // upper planes are after the byte
    const vfloat4 near = offset - slack + select(isNegative, scale, vfloat4(zero)),
                  far = offset + slack + select(isNegative, vfloat4(zero), scale);
    const vfloatV scales[3] = {broadcast<0>(scale), broadcast<1>(scale), broadcast<2>(scale)};
    const vfloatV nears[3] = {broadcast<0>(near), broadcast<1>(near), broadcast<2>(near)};
    const vfloatV fars[3] = {broadcast<0>(far), broadcast<1>(far), broadcast<2>(far)};
    const uint8_t* const planes = (const uint8_t*)tile + meshTilePlanes(groups, 0);
    set(groups, tnear, tfar, negativeAxes, isSafe, [&](uint32_t plane, int j, uint32_t k, bool isFar) {
      return madd(vfloatV(loadBytes(planes + groups * plane + vectorWidth * j)), scales[k], isFar ? fars[k] : nears[k]);
    });
  }
};

/*! Corners of a group's triangles, by lane. */
class MeshTileCorners {
public:
  __forceinline explicit MeshTileCorners(const MeshTileGroup& group) {
    const vintV mask(int((1u << group.cornerBits) - 1u));
    for (int c = 0; c < 3; c++)
      for (int j = 0; j < vectors; j++)
        set(group, c, j, loadPackedFields(group.corners[c], group.cornerBits, uint32_t(vectorWidth * j)) & mask);
  }

  static const int vectors = int(maxTileGroupTriangles) / vectorWidth;
#if defined(__AVX2__)
  vintV at[3][vectors];
  __forceinline void set(const MeshTileGroup&, int c, int j, const vintV& corners) { at[c][j] = corners; }
#else
  alignas(32) int at[3][maxTileGroupTriangles]; //!< 0 in lanes without a triangle, which are also used as indices

  __forceinline void set(const MeshTileGroup& group, int c, int j, const vintV& corners) {
    alignas(32) static constexpr int lanes[2 * maxTileGroupTriangles] = {-1, -1, -1, -1, -1, -1, -1, -1,
                                                                         -1, -1, -1, -1, -1, -1, -1, -1};
    const int* const used = lanes + maxTileGroupTriangles - group.numTriangles;
    vintV::store(at[c] + vectorWidth * j, corners & vintV::loadu(used + vectorWidth * j));
  }
#endif
};

/*! As for MeshTriangles. */
__forceinline auto cornersOf(const MeshTileCorners& corners, uint32_t n, int c) {
#if defined(__AVX2__)
  return corners.at[c][n / vectorWidth].v;
#else
  return corners.at[c] + n;
#endif
}

/*! A group in memory, for access to single triangles that a ray's line may pass through. A Cached of
 *  VertHitReporter. Tile: MeshTileBlock or MovingMeshTileBlock. */
template<typename Tile>
class MeshTileTriangles {
public:
  static const bool isMesh = true; //!< see hits1.h

  uint32_t mask; //!< of the triangles

  __forceinline MeshTileTriangles(const VertRay& ray, const Tile& tile, uint32_t g) : tile(tile), group(tile.group(g)) {
    mask = group.numVertices <= 16 ? test<16>(ray) : likely(group.numVertices <= 24) ? test<24>(ray) : test<32>(ray);
  }

  __forceinline TriangleSides<float> sides(uint32_t index) const { return lanes.at(index); }

  __forceinline VertTriangle triangle(uint32_t index) const {
    const uint8_t corners[3] = {group.corner(index, 0), group.corner(index, 1), group.corner(index, 2)};
    return VertTriangle(vertices, corners);
  }

  /*! See CachedMeshBlock::point. */
  __forceinline SurfacePoint point(uint32_t g, uint32_t index, float w1, float w2) const {
    return pointOfMesh(tile.info(), tile.number(g, index), w1, w2);
  }

private:
  template<int capacity>
  __forceinline uint32_t test(const VertRay& ray) {
    const int vectors = ShearedMesh<capacity>::vectors;
    const int axes[3] = {ray.kx, ray.ky, ray.kz};
    vfloatV at[3][vectors];
    tile.template vertices<vectors>(group, axes, at);
    const uint32_t hit = lanesHitByLine<capacity>(
                             ray, [&](int i, int j) { return at[i][j]; }, MeshTileCorners(group), lanes) &
                         (0xFFFFu >> (maxTileGroupTriangles - group.numTriangles));
    if (hit == 0) return 0;
    for (int i = 0; i < 3; i++)
      for (int j = 0; j < vectors; j++) vfloatV::store(vertices[axes[i]] + vectorWidth * j, at[i][j]);
    return hit;
  }

  const Tile& tile;
  const typename Tile::Group group;
  alignas(64) float vertices[3][32]; //!< [axis][vertex]
  SidesInLanes lanes;
};

template<typename Tile>
__forceinline VertTriangle triangleOf(const MeshTileTriangles<Tile>& group, uint32_t, uint32_t index) {
  return group.triangle(index);
}

/*! Intersects a ray with a mesh tile, the nearest groups first for closest hits. Target: see VertHitReporter. vertRay:
 *  as in intersectGroupBoxes. Returns true if a hit was accepted. Tile: MeshTileBlock or MovingMeshTileBlock. Boxes:
 *  MeshTileBoxes or MovingMeshTileBoxes. at: a moving tile's TimeInMotion. */
template<bool isAnyHit, typename Tile = MeshTileBlock, typename Boxes = MeshTileBoxes, typename Target, typename... At>
__forceinline bool intersectGroupsOfTile(const Target& target, const VertRay& vertRay, NearestVertHit& nearest,
                                         const MeshTileHeader* header, const At&... at) {
  const Boxes boxes(vertRay, header, target.tnear(), target.tfar(), at...);
  if (boxes.mask == 0) return false;
  const Tile tile(header, at...);
  bool found = false;
  for (uint32_t groups = boxes.mask; groups;) {
    const uint32_t g = isAnyHit ? popAny(groups) : popNearest(groups, boxes.enter);
    if (boxes.enter[g] > target.tfar()) continue;
    const MeshTileTriangles<Tile> triangles(vertRay, tile, g);
    if (triangles.mask == 0) continue;
    VertHitReporter<Target, MeshTileTriangles<Tile>> hits(target, vertRay, nearest, (const VertHeader*)header,
                                                          triangles);
    if (!hits.report(g, triangles)) continue;
    if (isAnyHit) return true;
    found = true;
  }
  return found;
}
} // namespace embree::isa::cbvh
