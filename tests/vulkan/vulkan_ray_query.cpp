// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Ray queries: the driver's structures find the blocks, and hits are those of the compute backend. */

#include "small_scenes.h"
#include "vulkan_tracer.h"
#include "support/diced_mesh.h"
#include "support/odd_rays.h"

#include <algorithm>

namespace cbvh::test {
namespace {

const RTCCompression allKinds[] = {RTC_COMPRESSION_NONE, RTC_COMPRESSION_GRID, RTC_COMPRESSION_VOXEL, RTC_COMPRESSION_LEAF, RTC_COMPRESSION_VERT};

// Rays by both ways of one scene.
struct Differences
{
  size_t rays = 0, hits = 0;
  size_t bits = 0;      // anything but the same bits
  size_t otherHit = 0;  // a hit for a miss, or the other way round, or other IDs
  size_t otherAny = 0;  // any hit is not what closest hit is
};

class VulkanRayQuery : public VulkanTest
{
protected:
  Random random{91};
  Displacement displacement;

  void SetUp() override
  {
    VulkanTest::SetUp();
    if (vulkan && !vulkan->handles.hasRayQuery) GTEST_SKIP() << vulkan->name << " has no ray queries";
  }

  SurfaceSettings settings(RTCCompression compression, float rate = 16)
  {
    SurfaceSettings s;
    s.displacement = &displacement;
    s.compression = compression;
    s.frameLevel = 1;
    s.rate = rate;
    return s;
  }

  Differences compare(RTCScene scene, const std::vector<RTCRayHit>& rays)
  {
    const VulkanScene compute = newVulkanScene(device, scene), query = newQueryScene(device, scene);
    EXPECT_NE(compute, nullptr) << embree.message;
    EXPECT_NE(query, nullptr) << embree.message;
    Differences found;
    if (!compute || !query) return found;
    std::vector<RTCRayHit> a = rays, b = rays;
    std::vector<RTCRay> any = withoutHits(rays);
    intersectOnDevice(compute, a);
    intersectOnDevice(query, b);
    occludedOnDevice(query, any);
    for (size_t i = 0; i < rays.size(); i++) {
      found.rays++;
      found.hits += isHit(a[i]);
      found.bits += std::memcmp(&a[i], &b[i], sizeof(RTCRayHit)) != 0;
      const bool same = isHit(a[i]) == isHit(b[i]) && (!isHit(a[i]) || (a[i].hit.geomID == b[i].hit.geomID && a[i].hit.primID == b[i].hit.primID && a[i].hit.instID[0] == b[i].hit.instID[0]));
      found.otherHit += !same;
      if (!same && isHit(a[i])&&isHit(b[i])) std::printf("%g %g  prim %u %u u %g %g v %g %g tnear %g\n", a[i].ray.tfar, b[i].ray.tfar-a[i].ray.tfar, a[i].hit.primID, b[i].hit.primID, a[i].hit.u,b[i].hit.u,a[i].hit.v,b[i].hit.v, a[i].ray.tnear); else if(!same) std::printf("miss\n");
      found.otherAny += isHit(b[i]) != (any[i].tfar < 0);
    }
    return found;
  }
};

TEST_F(VulkanRayQuery, HitsAreThoseOfComputeShaders)
{
  Cage creased = cubeCage();
  creased.creases = {{0,1}, {1,3}, {3,2}, {2,0}};
  creased.creaseWeights = {INFINITY, 2.5f, 0.7f, INFINITY};
  for (RTCCompression kind : allKinds)
    for (const Cage& cage : {cubeCage(), sheetCage(3), prismCage(7), creased}) {
      const SurfaceScene scene(embree, cage, settings(kind));
      const Differences found = compare(scene, raysAt(random, 10000));
      std::printf("%s: %zu hits, %zu differ in bits, %zu in what is hit, %zu any\n", kindName(kind), found.hits, found.bits, found.otherHit, found.otherAny);
      EXPECT_GT(found.hits, found.rays/10);
      EXPECT_EQ(found.otherHit, 0u) << kindName(kind);
      EXPECT_EQ(found.otherAny, 0u) << kindName(kind);
      if (kind == RTC_COMPRESSION_VERT) { EXPECT_EQ(found.bits, 0u); }
    }
}

} // namespace
} // namespace cbvh::test
