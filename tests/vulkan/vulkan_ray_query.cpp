// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Ray queries: the driver's structures find the blocks, and hits match the compute backend. */

#include "small_scenes.h"
#include "vulkan_tracer.h"
#include "support/diced.h"
#include "support/irregular_mesh.h"
#include "support/message_parts.h"
#include "support/moving_surface.h"
#include "support/odd_rays.h"

#include <algorithm>

namespace programs::test { namespace {

// Numbers of rays for which ray queries and compute shaders differ in one scene.
struct Differences {
  size_t rays = 0, hits = 0;
  size_t bits = 0;     // results that are not equal to the bit
  size_t otherHit = 0; // a hit instead of a miss, or the reverse, or different IDs
  size_t otherAny = 0; // any hit differs from closest hit
};

class VulkanRayQuery : public SharedVulkanTest {
protected:
  Random random{91};
  Displacement displacement;

  void SetUp() override {
    SharedVulkanTest::SetUp();
    if (vulkan && !vulkan->handles.hasRayQuery) skipProgram(vulkan->name + " does not support ray queries");
  }

  SurfaceSettings settings(RTCCompression compression, float rate = 16) {
    return displacedSettings(displacement, compression, rate);
  }

  Differences compare(RTCScene scene, const std::vector<RTCRayHit>& rays) {
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
      const bool same = isHit(a[i]) == isHit(b[i]) &&
                        (!isHit(a[i]) || (a[i].hit.geomID == b[i].hit.geomID && a[i].hit.primID == b[i].hit.primID &&
                                          a[i].hit.instID[0] == b[i].hit.instID[0]));
      found.otherHit += !same;
      found.otherAny += isHit(b[i]) != (any[i].tfar < 0);
    }
    return found;
  }
};

// bits: number of rays whose hits may differ by rounding; 0 for representations whose blocks do not overlap
void expectSame(const Differences& found, size_t bits = 0) {
  EXPECT_GT(found.hits, found.rays / 20) << "too many rays miss";
  EXPECT_LE(found.bits, bits);
  EXPECT_EQ(found.otherHit, 0u);
  EXPECT_EQ(found.otherAny, 0u);
}

TEST_F(VulkanRayQuery, HitsMatchComputeShaders) {
  Cage creased = cubeCage();
  creased.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  creased.creaseWeights = {INFINITY, 2.5f, 0.7f, INFINITY};
  for (RTCCompression kind : allKinds)
    for (const Cage& cage : {cubeCage(), sheetCage(3), prismCage(7), creased}) {
      const SurfaceScene scene(embree, cage, settings(kind));
      const Differences found = compare(scene, raysAt(random, 10000));
      SCOPED_TRACE(kindName(kind));
      expectSame(found, kind == RTC_COMPRESSION_CVERT || kind == RTC_COMPRESSION_CGRID ? 0 : found.hits / 1000);
    }
}

TEST_F(VulkanRayQuery, GridsAndMeshesMatchComputeShaders) {
  for (const Diced& diced : {dicedSheet(6, 8), dicedSheet(1, 64), dicedBall(2, 11)}) {
    Scene scene(embree);
    rtcAttachGeometryByID(scene, newGrids(embree, diced, RTC_COMPRESSION_CVERT), 3);
    rtcReleaseGeometry(rtcGetGeometry(scene, 3));
    rtcCommitScene(scene);
    expectSame(compare(scene, raysAt(random, 4000)));
  }
  const DicedMesh quads = meshOf(dicedSheet(3, 16), allQuadOrders[0], random);
  for (const DicedMesh& mesh : {quads, trianglesOf(quads, 1, 2)}) {
    Scene scene(embree);
    attach(scene, newMesh(embree, mesh, RTC_COMPRESSION_CVERT));
    rtcCommitScene(scene);
    expectSame(compare(scene, raysAt(random, 4000)));
  }
}

TEST_F(VulkanRayQuery, MeshBlocksMatchComputeShaders) {
  Scene inside(embree), scene(embree);
  for (const NamedMesh& shape : irregularMeshes(random, 0)) {
    SCOPED_TRACE(shape.name);
    const MeshScene alone(embree, shape.mesh);
    expectSame(compare(alone, raysAt(random, 4000)));
    attach(inside, newMesh(embree, shape.mesh, RTC_COMPRESSION_CVERT));
  }
  rtcCommitScene(inside);
  attachMovingInstances(embree, scene, inside, random);
  rtcCommitScene(scene);
  expectSame(compare(scene, maskedTimedRays(random, 10000)));
}

// Different kinds next to each other with masks, triangles of a mesh, a disabled geometry, and ranges of rays.
TEST_F(VulkanRayQuery, MixedScenesMatchComputeShaders) {
  Scene scene(embree);
  Displacement displacements[6];
  addSurfacesOfAllKinds(embree, scene, displacements);
  attach(scene, newTriangle(embree, 0.1f));
  attach(scene, newTriangle(embree, -0.2f));
  rtcDisableGeometry(rtcGetGeometry(scene, 1));
  rtcCommitScene(scene);
  std::vector<RTCRayHit> rays = raysAt(random, 20000, 0.9f);
  for (size_t i = 0; i < rays.size(); i++) {
    rays[i].ray.mask = unsigned(random.below(64));
    if (i % 2) continue; // directions have a length of about 4
    rays[i].ray.tnear = float(random.uniform(0.2, 1));
    rays[i].ray.tfar = rays[i].ray.tnear + float(random.uniform(0, 0.8));
  }
  const Differences found = compare(scene, rays);
  expectSame(found, found.hits / 1000);
}

TEST_F(VulkanRayQuery, NonFiniteRaysMiss) {
  const SurfaceScene scene(embree, cubeCage(), settings(RTC_COMPRESSION_CVERT));
  const VulkanScene query = newQueryScene(device, scene);
  ASSERT_NE(query, nullptr) << embree.message;
  std::vector<RTCRayHit> rays = raysAt(random, 4096);
  for (RTCRayHit& ray : rays) spoil(ray.ray, random);
  std::vector<RTCRayHit> found = rays;
  std::vector<RTCRay> any = withoutHits(rays);
  intersectOnDevice(query, found);
  occludedOnDevice(query, any);
  EXPECT_TRUE(areSame(found, rays));
  EXPECT_TRUE(areSame(any, withoutHits(rays)));
}

// Rays from inside a closed surface at shared vertices and edges of blocks.
TEST_F(VulkanRayQuery, RaysOfEveryLengthHitAClosedSurface) {
  AllVertices recorder;
  Scene scene(embree);
  recorder.build(embree, scene, cubeCage(), settings(RTC_COMPRESSION_CVERT, 32));
  const VulkanScene query = newQueryScene(device, scene);
  ASSERT_NE(query, nullptr) << embree.message;
  const std::vector<RTCRayHit> rays = raysNextToVertices(random, recorder.taken(), 8192);
  for (int exponent : oddExponents) {
    std::vector<RTCRayHit> found = withDirections(rays, std::ldexp(1.0f, exponent));
    std::vector<RTCRay> any = withoutHits(found);
    intersectOnDevice(query, found);
    occludedOnDevice(query, any);
    size_t leaks = 0;
    for (size_t i = 0; i < rays.size(); i++) leaks += !isHit(found[i]) + !(any[i].tfar < 0);
    EXPECT_EQ(leaks, 0u) << "length 2^" << exponent;
  }
}

// Surfaces far from the origin, and rays from the largest supported distance.
TEST_F(VulkanRayQuery, DistantRaysHitTheirTargets) {
  for (float offset : {0.f, 1e3f}) {
    displacement.offset = {offset, -offset, 0.5f * offset};
    const SurfaceScene scene(embree, cubeCage(), settings(RTC_COMPRESSION_CVERT));
    std::vector<RTCRayHit> rays;
    for (int i = 0; i < 20000; i++) {
      Vec d, target, org;
      for (float& x : d) x = float(random.normal());
      const float distance = 20 * std::max(1.f, offset) / std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      for (int k = 0; k < 3; k++) {
        target[k] = displacement.offset[k] + float(random.uniform(-0.7, 0.7));
        org[k] = target[k] + distance * d[k];
      }
      rays.push_back(makeRay(org, {target[0] - org[0], target[1] - org[1], target[2] - org[2]}));
    }
    expectSame(compare(scene, rays));
  }
}

TEST_F(VulkanRayQuery, InstancesMatchComputeShaders) {
  Scene inside(embree), scene(embree);
  addSurface(embree, inside, cubeCage(), settings(RTC_COMPRESSION_CVERT));
  addSurface(embree, inside, sheetCage(3), settings(RTC_COMPRESSION_CLEAF));
  attach(inside, newTriangle(embree, 0.3f));
  rtcCommitScene(inside);
  addSurface(embree, scene, prismCage(5), settings(RTC_COMPRESSION_CVERT));
  attachMovingInstances(embree, scene, inside, random);
  attachInvalidInstances(embree, scene, inside);
  rtcCommitScene(scene);
  std::vector<RTCRayHit> rays = maskedTimedRays(random, 20000);
  for (size_t i = 0; i < rays.size(); i += 97) rays[i].ray.time = i % 2 ? NAN : INFINITY;
  const Differences found = compare(scene, rays);
  expectSame(found, found.hits / 1000); // blocks of cLEAF overlap
}

TEST_F(VulkanRayQuery, MovingGeometryMatchesComputeShaders) {
  Scene scene(embree);
  Displacement others[4];
  for (unsigned i = 0; i < 4; i++) {
    SurfaceSettings s = settings(RTC_COMPRESSION_CVERT);
    s.timeSteps = 1 + i;
    s.motion = [](const Vec& p, unsigned step) { return twisted(p, 0.3 * step); };
    if (i > 1) {
      s.begin = 0.25f * float(i) - 0.4f;
      s.end = s.begin + 0.5f;
    }
    others[i].offset = {0.8f * float(i) - 1.2f, 0.3f * float(i % 2), 0.2f * float(i % 3)};
    others[i].scale = 0.5f;
    s.displacement = &others[i];
    addSurface(embree, scene, i % 2 ? cubeCage() : prismCage(5), s);
  }
  rtcCommitScene(scene);
  std::vector<RTCRayHit> rays = timedRays(random, 20000);
  for (size_t i = 0; i < rays.size(); i += 97) rays[i].ray.time = i % 2 ? NAN : INFINITY;
  expectSame(compare(scene, rays));
}

TEST_F(VulkanRayQuery, EmptyScenesHaveNoHits) {
  Scene scene(embree);
  rtcCommitScene(scene);
  const VulkanScene query = newQueryScene(device, scene);
  ASSERT_NE(query, nullptr) << embree.message;
  EXPECT_EQ(rtcGetVulkanSceneInstances(query.get(), nullptr, 0), 0u);
  std::vector<RTCRayHit> rays = raysFromAbove(), found = rays;
  intersectOnDevice(query, found);
  EXPECT_TRUE(areSame(found, rays));
}

// Instances with the same motion have the same boxes in world space, and share the structure over them.
TEST_F(VulkanRayQuery, StatisticsCountASharedStructureOnce) {
  Scene inside(embree);
  addSurface(embree, inside, cubeCage(), settings(RTC_COMPRESSION_CVERT));
  rtcCommitScene(inside);
  std::vector<RTCVulkanSceneStatistics> statistics;
  for (size_t count : {1u, 2u}) {
    Scene scene(embree);
    for (size_t i = 0; i < count; i++) attach(scene, newInstance(embree, inside, 0.5f, 2));
    rtcCommitScene(scene);
    const VulkanScene query = newQueryScene(device, scene);
    ASSERT_NE(query, nullptr) << embree.message;
    EXPECT_EQ(rtcGetVulkanSceneInstances(query.get(), nullptr, 0), count);
    statistics.emplace_back();
    rtcGetVulkanSceneStatistics(query.get(), &statistics.back());
    EXPECT_EQ(statistics.back().numBuiltBoxes, statistics.back().numBoxes) << "no other scene has them";
  }
  EXPECT_GT(statistics[0].numBoxes, 0u);
  EXPECT_EQ(statistics[1].numBoxes, statistics[0].numBoxes);
}

TEST_F(VulkanRayQuery, EditUpdatesOnlyChangedStructures) {
  Scene scene(embree);
  Displacement others[3];
  std::vector<RTCGeometry> geometries;
  for (unsigned i = 0; i < 3; i++) {
    others[i].offset = {1.2f * float(i) - 1.2f, 0, 0};
    others[i].scale = 0.5f;
    SurfaceSettings s = settings(RTC_COMPRESSION_CVERT);
    s.displacement = &others[i];
    geometries.push_back(newSurface(embree, cubeCage(), s));
    rtcAttachGeometry(scene, geometries.back());
  }
  rtcCommitScene(scene);
  const auto statisticsOfQuery = [](const VulkanScene& query) {
    RTCVulkanSceneStatistics statistics;
    rtcGetVulkanSceneStatistics(query.get(), &statistics);
    return statistics;
  };
  VulkanScene before = newQueryScene(device, scene);
  ASSERT_NE(before, nullptr) << embree.message;
  const size_t all = statisticsOfQuery(before).numBoxes;
  EXPECT_GT(statisticsOfQuery(before).structureBytes, 64 * all / 4);
  EXPECT_EQ(statisticsOfQuery(before).numBuiltBoxes, all);
  EXPECT_EQ(statisticsOfQuery(newQueryScene(device, scene)).numBuiltBoxes, 0u); // no change

  const std::vector<RTCRayHit> rays = raysAt(random, 5000);
  for (int edit = 0; edit < 3; edit++) {
    others[1].offset[1] = 0.1f * float(edit + 1);
    rtcCommitGeometry(geometries[1]);
    rtcCommitScene(scene);
    VulkanScene after = newQueryScene(device, scene, edit ? before.get() : nullptr);
    ASSERT_NE(after, nullptr) << embree.message;
    const RTCVulkanSceneStatistics statistics = statisticsOfQuery(after);
    EXPECT_EQ(statistics.numBoxes, all);
    EXPECT_EQ(statistics.numBuiltBoxes, edit ? 0 : all / 3);
    EXPECT_EQ(statistics.numUpdatedBoxes, edit ? all / 3 : 0);
    const VulkanScene compute = newVulkanScene(device, scene);
    std::vector<RTCRayHit> a = rays, b = rays;
    intersectOnDevice(after, a);
    intersectOnDevice(compute, b);
    EXPECT_TRUE(areSame(a, b)) << "edit " << edit;
    before = std::move(after);
  }
  for (RTCGeometry geometry : geometries) rtcReleaseGeometry(geometry);
}

TEST_F(VulkanRayQuery, UnsupportedUsesAreRejected) {
  const SurfaceScene scene(embree, cubeCage(), settings(RTC_COMPRESSION_CVERT));
  const VulkanScene compute = newVulkanScene(device, scene), query = newQueryScene(device, scene);
  EXPECT_EQ(rtcGetVulkanSceneInstances(compute.get(), nullptr, 0), 0u);
  EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_TRUE(has(embree.message, "ray queries")) << embree.message;
  EXPECT_EQ(rtcGetVulkanSceneInstances(query.get(), nullptr, 0), 1u);

  EXPECT_EQ(newQueryScene(device, scene, compute.get()), nullptr);
  EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(has(embree.message, "previousScene")) << embree.message;

  RTCVulkanSceneArguments args = {};
  args.traversal = RTCVulkanTraversal(7);
  EXPECT_EQ(rtcNewVulkanScene(device.get(), scene, &args), nullptr);
  EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(embree.message, {"traversal", " 7"}));

  RTCVulkanDeviceHandles handles = vulkan->handles;
  handles.hasRayQuery = 0;
  const VulkanDevice without = open(handles);
  EXPECT_EQ(newQueryScene(without, scene), nullptr);
  EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_TRUE(containsInOrder(embree.message, {vulkan->name, "VK_KHR_ray_query"}));
}

}} // namespace programs::test
