// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Moving geometry has the same hits on the device and on the CPU at every time. */

#include "agreement.h"
#include "support/diced.h"
#include "support/diced_mesh.h"
#include "support/moving_surface.h"

namespace programs::test { namespace {

class VulkanMotion : public VulkanAgreement {
protected:
  Displacement displacement;

  SurfaceSettings settings(unsigned timeSteps, float rate = 16) {
    SurfaceSettings s;
    s.displacement = &displacement;
    s.compression = timeSteps == 3 ? RTC_COMPRESSION_CTILE : RTC_COMPRESSION_CVERT;
    s.rate = rate;
    s.timeSteps = timeSteps;
    s.motion = [](const Vec& p, unsigned i) { return twisted(p, 0.3 * i); };
    return s;
  }
};

TEST_F(VulkanMotion, MovingCagesMatchCpu) {
  Agreement sum;
  Cage creased = cubeCage();
  creased.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  creased.creaseWeights = {INFINITY, 2.5f, 0.7f, INFINITY};
  Cage withHole = sheetCage(4);
  withHole.holes = {5};
  for (const Cage& cage : {cubeCage(), creased, withHole, prismCage(5), trapezohedronCage(9)})
    for (unsigned timeSteps : {2u, 3u, 9u})
      for (float rate : {1.f, 5.f, 33.f}) {
        SCOPED_TRACE(testing::Message() << cage.faces.size() << " faces, " << timeSteps << " steps, rate " << rate);
        const SurfaceScene scene(embree, cage, settings(timeSteps, rate));
        ASSERT_GT(statisticsOf(scene).numMovingQuads, 0u);
        compare(scene, timedRays(random, 1500), sum, rate == 5 ? RTC_VULKAN_MEMORY_COPY : RTC_VULKAN_MEMORY_AUTO);
      }
  sum.expect();
}

// Residuals of later steps cannot be predicted from the first, and blocks overlap along rays.
TEST_F(VulkanMotion, RandomMotionMatchesCpu) {
  Agreement sum;
  displacement.amplitude = 0.2f;
  displacement.frequency = 40;
  SurfaceSettings s = settings(3, 32);
  s.maxError = 1e-4f;
  const SurfaceScene scene(embree, cubeCage(), s);
  compare(scene, timedRays(random, 6000), sum);
  sum.expect();
}

TEST_F(VulkanMotion, LosslessMotionMatchesCpu) {
  const Device exact("cbvh_max_error=0");
  Agreement sum;
  for (unsigned timeSteps : {2u, 5u}) {
    const SurfaceScene scene(exact, cubeCage(), settings(timeSteps, 16));
    ASSERT_EQ(statisticsOf(scene).maxVertexSpacing, 0);
    compare(scene, timedRays(random, 3000), sum);
  }
  sum.expect();
}

// Times before, at and after the ends of ranges, and NaN.
TEST_F(VulkanMotion, TimeRangesMatchCpu) {
  Agreement sum;
  Displacement others[3];
  Scene scene(embree);
  for (unsigned i = 0; i < 3; i++) {
    SurfaceSettings s = settings(2 + i, 8);
    others[i].offset = {0.8f * float(i) - 0.8f, 0, 0};
    others[i].scale = 0.5f;
    s.displacement = &others[i];
    s.begin = 0.25f * float(i);
    s.end = s.begin + 0.5f;
    addSurface(embree, scene, cubeCage(), s);
  }
  rtcCommitScene(scene);
  std::vector<RTCRayHit> rays = raysAt(random, 20000);
  for (size_t i = 0; i < rays.size(); i++)
    rays[i].ray.time = i % 4 == 0   ? float(random.uniform())
                       : i % 4 == 1 ? 0.125f * float(random.below(9))
                       : i % 4 == 2 ? std::nextafter(0.25f * float(random.below(5)), float(random.below(2)))
                                    : float(random.uniform(0.2, 0.3));
  for (size_t i = 0; i < rays.size(); i += 97) rays[i].ray.time = i % 2 ? NAN : INFINITY;
  compare(scene, rays, sum);
  sum.expect();
}

TEST_F(VulkanMotion, MovingNextToStaticGeometryMatchesCpu) {
  Scene scene(embree);
  Displacement others[4];
  for (unsigned i = 0; i < 4; i++) {
    SurfaceSettings s = settings(i % 2 ? 3 : 1);
    others[i].offset = {0.8f * float(i) - 1.2f, 0.3f * float(i % 2), 0.2f * float(i % 3)};
    others[i].scale = 0.5f;
    s.displacement = &others[i];
    s.mask = 1u << i;
    if (i == 0) s.compression = RTC_COMPRESSION_CLEAF;
    addSurface(embree, scene, i % 2 ? cubeCage() : prismCage(5), s);
  }
  attach(scene, newTriangle(embree, 0.1f));
  rtcCommitScene(scene);
  std::vector<RTCRayHit> rays = timedRays(random, 20000);
  for (RTCRayHit& ray : rays) ray.ray.mask = unsigned(random.below(16));
  Agreement sum;
  compare(scene, rays, sum);
  sum.expect();
}

TEST_F(VulkanMotion, MovingGridsAndMeshesMatchCpu) {
  Agreement sum;
  for (unsigned timeSteps : {2u, 4u}) {
    const RTCCompression form = timeSteps == 2 ? RTC_COMPRESSION_CTILE : RTC_COMPRESSION_CVERT;
    for (const Diced& diced : {dicedSheet(6, 8), dicedSheet(1, 64), dicedBall(2, 11)}) {
      Scene scene(embree);
      attach(scene, newGrids(embree, diced, form, 0, timeSteps));
      rtcCommitScene(scene);
      ASSERT_GT(statisticsOf(scene).numMovingQuads, 0u);
      compare(scene, timedRays(random, 2000), sum);
    }
    const DicedMesh quads = meshOf(dicedSheet(3, 16), allQuadOrders[0], random);
    for (DicedMesh mesh : {quads, trianglesOf(quads, 1, 2)}) {
      Scene scene(embree);
      attach(scene, newMesh(embree, mesh, form, 0, timeSteps));
      rtcCommitScene(scene);
      ASSERT_GT(statisticsOf(scene).numMovingQuads, 0u);
      compare(scene, timedRays(random, 2000), sum);
    }
  }
  sum.expect();
}

TEST_F(VulkanMotion, MovingInstancesMatchCpu) {
  Scene inside(embree), scene(embree);
  SurfaceSettings still = settings(1);
  addSurface(embree, inside, cubeCage(), settings(3));
  addSurface(embree, inside, sheetCage(3), still);
  rtcCommitScene(inside);
  attachMovingInstances(embree, scene, inside, random);
  rtcCommitScene(scene);
  Agreement sum;
  compare(scene, maskedTimedRays(random, 20000), sum);
  sum.expect();
}

TEST_F(VulkanMotion, InvalidInstancesMatchCpu) {
  Scene inside(embree), scene(embree);
  addSurface(embree, inside, cubeCage(), settings(1));
  rtcCommitScene(inside);
  attachMovingInstances(embree, scene, inside, random);
  attachInvalidInstances(embree, scene, inside);
  rtcCommitScene(scene);
  Agreement sum;
  compare(scene, maskedTimedRays(random, 5000), sum);
  sum.expect();
}

// A vertex that is not finite at one step, so that blocks are raw there.
TEST_F(VulkanMotion, NonFiniteStepsMatchCpu) {
  Agreement sum;
  for (unsigned bad : {0u, 1u, 3u}) {
    SurfaceSettings s = settings(4);
    s.motion = [bad](const Vec& p, unsigned i) {
      return i == bad && p[0] < 0 && p[1] < 0 && p[2] < 0 ? Vec{NAN, 0, 0} : twisted(p, 0.2 * i);
    };
    const SurfaceScene scene(embree, cubeCage(), s);
    EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_ARGUMENT); // reports the vertices
    compare(scene, timedRays(random, 4000), sum);
  }
  sum.expect();
}

TEST_F(VulkanMotion, ClosedMovingSurfacesDoNotLeak) {
  size_t rays = 0;
  for (const Cage& cage : {cubeCage(), prismCage(7), trapezohedronCage(5)})
    for (unsigned timeSteps : {2u, 4u}) {
      displacement.amplitude = 0.1f;
      SurfaceSettings s = settings(timeSteps);
      // rates and owners differ
      for (size_t i = 0; i < cage.indices.size(); i++) s.edgeRates.push_back(float(1 + (7 * i) % 23));
      RTCGeometry geometry = newSurface(embree, cage, s);
      Scene scene(embree);
      rtcAttachGeometry(scene, geometry);
      rtcCommitScene(scene);
      std::vector<RTCRayHit> found = raysAtMovingSurface(random, geometry, 20, 1000);
      std::vector<RTCRay> any = withoutHits(found);
      const VulkanScene onDevice = newVulkanScene(device, scene);
      ASSERT_NE(onDevice, nullptr) << embree.message;
      intersectOnDevice(onDevice, found);
      occludedOnDevice(onDevice, any);
      for (size_t i = 0; i < found.size(); i++)
        ASSERT_TRUE(isHit(found[i]) && any[i].tfar < 0) << "ray " << i << " at time " << found[i].ray.time;
      rays += found.size();
      rtcReleaseGeometry(geometry);
    }
  EXPECT_EQ(rays, 120000u);
}

}} // namespace programs::test
