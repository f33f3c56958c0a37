// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* libFuzzer target: random bytes as a ray and a mesh block. Blocks must be valid, as before traversal. For static
 * blocks the decoder of this instruction set equals the scalar one. Traversal must not read outside of the block and
 * its padding, must not have undefined behavior, and must terminate; fuzz_traversal.h checks its hits. */

#include "fuzz_traversal.h"
#include "mesh_seeds.h"
#include "kernels/cbvh/exact/mesh_intersector1.h"
#include "kernels/cbvh/exact/moving_mesh_intersector1.h"
#include "kernels/cvert/decoder/decoded_mesh.h"
#include "kernels/cvert/conversion/mesh_tile_conversion.h"

#include <algorithm>

namespace programs::test {

void writeSeeds(const std::string& folder) {
  forEachMeshSeed([&](const std::string& name, const void* block, size_t bytes) {
    writeSeedsWithRays(folder + "/" + name, block, bytes);
  });
}

namespace {

using namespace embree::isa;
using namespace embree::cbvh;
using embree::isa::cbvh::CachedMeshBlock;
using embree::isa::cbvh::intersectMesh;
using embree::isa::cbvh::intersectMeshTile;
using embree::isa::cbvh::intersectMovingMesh;
using embree::isa::cbvh::VertRay;

bool areEqual(float a, float b) { return memcmp(&a, &b, sizeof(a)) == 0 || (std::isnan(a) && std::isnan(b)); }

void compareWithScalarDecoder(const MeshHeader* block) {
  const MeshView view(block);
  const CachedMeshBlock cached(VertRay(), (const VertHeader*)block);
  REQUIRE(cached.boxes().lanes == (1u << view.groups) - 1);
  for (uint32_t g = 0; g < view.groups; g++) {
    const DecodedMeshGroup group(view, g);
    for (uint32_t t = 0; t < group.numTriangles; t++) {
      const MeshTriangles& half = cached.triangles(g, t / 16);
      REQUIRE((half.lanes >> t % 16) & 1);
      for (int c = 0; c < 3; c++)
        for (int k = 0; k < 3; k++)
          REQUIRE(areEqual(half.vertices.at[k][half.corners[c][t % 16]], group.corners[c][k][t]));
    }
  }
}

template<typename RayType>
bool intersect(RayType& ray, IntersectContext* context, const MeshHeader* block) {
  VertRay pre;
  return isMovingMesh(block) ? intersectMovingMesh(ray, context, pre, block) : intersectMesh(ray, context, pre, block);
}

// The tile of a block has the same hits.
void compareWithTile(RTCScene scene, const RayBytes& bytes, const HitLimits& limits, const MeshHeader* block) {
  std::vector<uint8_t> written(maxBytesOfMeshTile);
  const size_t size = tileOfMesh(block, written.data());
  if (size == 0) return;
  written.resize(size + meshTileReadPadding);
  const ExactMemory memory(written.data(), written.size(), 16);
  const void* const tile = memory.get();
  traceAndCompare(scene, bytes, limits, [&](auto& at, IntersectContext* context) {
    VertRay pre;
    return intersectMeshTile(at, context, pre, tile);
  });

  RTCIntersectContext plain;
  rtcInitIntersectContext(&plain);
  IntersectContext context((Scene*)scene, &plain);
  RayHit hits[2] = {RayHit(bytes.ray()), RayHit(bytes.ray())};
  for (RayHit& hit : hits) {
    hit.Ng = Vec3f(0.0f);
    hit.u = hit.v = 0.0f;
    hit.primID = 0;
    hit.geomID = hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  }
  VertRay pre[2];
  intersectMesh(hits[0], &context, pre[0], block);
  intersectMeshTile(hits[1], &context, pre[1], tile);
  REQUIRE(memcmp(&hits[0], &hits[1], sizeof(RTCRayHit)) == 0);
}

} // namespace
} // namespace programs::test

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace ::programs::test;
  static const World world;
  RayBytes ray;
  if (!ray.read(data, size, sizeof(MeshHeader))) return 0;
  std::vector<uint8_t> padded(data, data + size);
  padded.resize(size + vertReadPadding);
  const ExactMemory memory(padded.data(), padded.size(), 16);
  MeshHeader* const block = (MeshHeader*)memory.get();
  if (validateMesh(block, size)) return 0;
  block->surface = 0;
  invalidateThreadCaches();
  if (!isMovingMesh(block)) compareWithScalarDecoder(block);
  const HitLimits limits = {meshTriangles(block->counts), 0, 0};
  traceAndCompare(world.scene, ray, limits,
                  [&](auto& at, IntersectContext* context) { return intersect(at, context, block); });
  if (!isMovingMesh(block)) compareWithTile(world.scene, ray, limits, block);
  return 0;
}
