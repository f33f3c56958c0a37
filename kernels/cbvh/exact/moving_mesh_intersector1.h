// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Single-ray intersectors of moving mesh blocks and mesh tiles. */

#include "mesh_tile_intersector1.h"
#include "moving_intersector1.h"
#include "moving_mesh_block.h"

namespace embree::isa::cbvh {
/*! MeshTileBoxes of a moving mesh tile. */
class MovingMeshTileBoxes : public EnteredGroups {
public:
  __forceinline MovingMeshTileBoxes(const VertRay& ray, const MeshTileHeader* tile, float tnear, float tfar,
                                    const TimeInMotion& at) {
    const MovingGroupPlanes planes(tile, at);
    const vfloat4 rcp = vfloat4::load(ray.rcp), distance = planes.origin - vfloat4::load(ray.org);
    const vfloat4 slack = planes.slackOf(distance) * abs(rcp), offset = distance * rcp;
    const vfloat4 begin = planes.units[0] * rcp, end = planes.units[1] * rcp, both = begin + end;
    // see LeafBoxes
    const bool isSafe = all(vfloat4(257.0f) * (abs(begin) + abs(end)) + abs(offset) + slack < vfloat4(1e37f));
    const vboolf4 isNegative = rcp < vfloat4(zero);
    // upper planes are after the byte
    const vfloat4 near = offset - slack + select(isNegative, both, vfloat4(zero)),
                  far = offset + slack + select(isNegative, vfloat4(zero), both);
    const vfloatV begins[3] = {broadcast<0>(begin), broadcast<1>(begin), broadcast<2>(begin)};
    const vfloatV ends[3] = {broadcast<0>(end), broadcast<1>(end), broadcast<2>(end)};
    const vfloatV nears[3] = {broadcast<0>(near), broadcast<1>(near), broadcast<2>(near)};
    const vfloatV fars[3] = {broadcast<0>(far), broadcast<1>(far), broadcast<2>(far)};
    set(planes.groups, tnear, tfar, uint32_t(movemask(isNegative)), isSafe,
        [&](uint32_t plane, int j, uint32_t k, bool isFar) {
          const uint32_t n = planes.groups * plane + uint32_t(vectorWidth * j);
          const vfloatV atEnd = madd(vfloatV(loadBytes(planes.boxes[1] + n)), ends[k], isFar ? fars[k] : nears[k]);
          return madd(vfloatV(loadBytes(planes.boxes[0] + n)), begins[k], atEnd);
        });
  }
};

template<typename RayType>
__noinline bool intersectMovingMeshTile(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* header) {
  const MeshTileHeader* const tile = (const MeshTileHeader*)header;
  const VertMotion motion = motionOfMeshTile(tile);
  if (unlikely(!isPresent(motion, ray.time()))) return false;
  vertRay.set(ray);
  return intersectGroupsOfTile<IsAnyHit<RayType>::value, MovingMeshTileBlock, MovingMeshTileBoxes>(
      VertTarget1<RayType>{ray, context}, vertRay, vertRay.nearest, tile, timeInMotion(motion, ray.time()));
}

/*! block: a MeshHeader. */
template<typename RayType>
__noinline bool intersectMovingMesh(RayType& ray, IntersectContext* context, VertRay& vertRay, const void* block) {
  const VertMotion motion = motionOfMesh((const MeshHeader*)block);
  if (unlikely(!isPresent(motion, ray.time()))) return false;
  return VertIntersector1<RayType, MovingMeshBlock>::intersect(ray, context, vertRay, (const VertHeader*)block,
                                                               timeInMotion(motion, ray.time()));
}
} // namespace embree::isa::cbvh
