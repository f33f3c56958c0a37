// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersectors of moving blocks and tiles of quads. */

#include "intersector1.h"
#include "moving_block.h"
#include "tile_intersector1.h"

namespace embree::isa::cbvh {
template<typename RayType>
__noinline bool intersectMovingVert(RayType& ray, IntersectContext* context, VertRay& vertRay,
                                    const VertHeader* block) {
  const VertMotion motion = motionOf(block);
  if (unlikely(!isPresent(motion, ray.time()))) return false;
  return VertIntersector1<RayType, MovingVertBlock>::intersect(ray, context, vertRay, block,
                                                               timeInMotion(motion, ray.time()));
}

/*! LeafBoxes of a moving tile. */
class MovingLeafBoxes : public EnteredLeaves {
public:
  __forceinline MovingLeafBoxes(const VertRay& ray, const VertHeader* tile, float tnear, float tfar,
                                const TimeInMotion& at)
    : EnteredLeaves(tile->region) {
    const MovingLeafPlanes planes(tile, at);
    const vfloat4 rcp = vfloat4::load(ray.rcp), distance = planes.origin - vfloat4::load(ray.org);
    const vfloat4 slack = planes.slackOf(distance) * abs(rcp), offset = distance * rcp;
    const vfloat4 begin = planes.units[0] * rcp, end = planes.units[1] * rcp;
    const vfloat4 nearOffset = offset - slack, farOffset = offset + slack;
    // see LeafBoxes
    const bool isSafe =
        all(vfloat4(float(maxBoxByte + 1)) * (abs(begin) + abs(end)) + abs(offset) + slack < vfloat4(1e37f));
    const vfloatV begins[3] = {broadcast<0>(begin), broadcast<1>(begin), broadcast<2>(begin)};
    const vfloatV ends[3] = {broadcast<0>(end), broadcast<1>(end), broadcast<2>(end)};
    const vfloatV nears[3] = {broadcast<0>(nearOffset), broadcast<1>(nearOffset), broadcast<2>(nearOffset)};
    const vfloatV fars[3] = {broadcast<0>(farOffset), broadcast<1>(farOffset), broadcast<2>(farOffset)};
    set(ray, tile->region, tnear, tfar, isSafe, [&](uint32_t offset, uint32_t k, bool isFar) {
      const vfloatV atEnd = madd(vfloatV(loadBytes(planes.boxes[1] + offset)), ends[k], isFar ? fars[k] : nears[k]);
      return madd(vfloatV(loadBytes(planes.boxes[0] + offset)), begins[k], atEnd);
    });
  }
};

template<typename RayType>
__noinline bool intersectMovingTile(RayType& ray, IntersectContext* context, VertRay& vertRay, const VertHeader* tile) {
  const VertMotion motion = motionOf(tile);
  if (unlikely(!isPresent(motion, ray.time()))) return false;
  return TileIntersector1<RayType, MovingTileBlock, MovingLeafBoxes>::intersect(ray, context, vertRay, tile,
                                                                                timeInMotion(motion, ray.time()));
}

/*! block: a MeshHeader. traversal/mesh_intersector1.cpp defines the function for Ray and RayHit. */
template<typename RayType>
bool intersectMovingMesh(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* block);

/*! The same for a mesh tile. */
template<typename RayType>
bool intersectMovingMeshTile(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* tile);
} // namespace embree::isa::cbvh
