// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The ways to trace: from the host and in the application's command buffers, one at a time and several at once. */

#include "api_fixture.h"
#include "recorded_trace.h"

#include <limits>
#include <thread>

namespace programs::test { namespace {

using VulkanTraces = VulkanAPI;

// --- input -------------------------------------------------------------------------------------------

TEST_F(VulkanTraces, EmptyScenesHaveNoHits) {
  const std::vector<RTCRayHit> rays = raysFromAbove();
  const std::vector<RTCRay> shadowRays = withoutHits(rays);
  Scene empty(embree), disabled(embree), noFaces(embree), ofEmpty(embree);
  rtcCommitScene(empty);
  attach(disabled, newTriangle(embree, 0));
  rtcDisableGeometry(rtcGetGeometry(disabled, 0));
  rtcCommitScene(disabled);
  Cage none = sheetCage(1);
  none.holes = {0};
  addSurface(embree, noFaces, none, smallSurface(RTC_COMPRESSION_CLEAF));
  rtcCommitScene(noFaces);
  attach(ofEmpty, newInstance(embree, empty, 1));
  rtcCommitScene(ofEmpty);
  for (RTCScene scene : {RTCScene(empty), RTCScene(disabled), RTCScene(noFaces), RTCScene(ofEmpty)})
    for (RTCVulkanMemory memory : {RTC_VULKAN_MEMORY_COPY, RTC_VULKAN_MEMORY_AUTO}) {
      const VulkanScene uploaded = upload(scene, memory);
      ASSERT_TRUE(uploaded) << embree.message;
      EXPECT_TRUE(areSame(traceAll(uploaded.get(), rays), rays));
      std::vector<RTCRay> traced = shadowRays;
      EXPECT_TRUE(trace(uploaded.get(), traced));
      EXPECT_TRUE(areSame(traced, shadowRays));
    }
}

TEST_F(VulkanTraces, ZeroRaysFinishImmediately) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  std::vector<RTCRayHit> none;
  std::vector<RTCRay> noShadowRays;
  EXPECT_TRUE(trace(uploaded.get(), none)) << embree.message;
  EXPECT_TRUE(trace(uploaded.get(), noShadowRays)) << embree.message;
  RecordedTrace recorded(vulkan->handles);
  recorded.record([&](VkCommandBuffer commands) {
    EXPECT_TRUE(rtcRecordVulkanIntersect(uploaded.get(), commands, 0, 0));
    EXPECT_TRUE(rtcRecordVulkanOccluded(uploaded.get(), commands, 0, 0));
  });
}

TEST_F(VulkanTraces, InactiveRaysAreUnchanged) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  const float inf = std::numeric_limits<float>::infinity();
  std::vector<RTCRayHit> rays = raysFromAbove();
  const std::vector<RTCRayHit> hits = traceAll(uploaded.get(), rays);
  const size_t active = rays.size();
  for (const auto& [tnear, tfar] : {std::make_pair(0.0f, -inf), std::make_pair(7.0f, 6.0f), std::make_pair(inf, 0.0f),
                                    std::make_pair(0.0f, -1.0f)}) {
    RTCRayHit ray = rays[0];
    ray.ray.tnear = tnear;
    ray.ray.tfar = tfar;
    ray.hit.u = 77;
    ray.hit.primID = 78;
    rays.push_back(ray);
  }
  const std::vector<RTCRayHit> traced = traceAll(uploaded.get(), rays);
  std::vector<RTCRayHit> expected = hits;
  expected.insert(expected.end(), rays.begin() + ptrdiff_t(active), rays.end());
  EXPECT_TRUE(areSame(traced, expected)) << "active rays are traced, inactive ones are unchanged";
  const std::vector<RTCRay> shadowRays = withoutHits(rays);
  std::vector<RTCRay> occluded = shadowRays;
  EXPECT_TRUE(trace(uploaded.get(), occluded));
  for (size_t i = 0; i < rays.size(); i++) {
    if (i < active && isHit(hits[i])) {
      EXPECT_EQ(occluded[i].tfar, -inf) << i;
    } else {
      EXPECT_EQ(std::memcmp(&occluded[i], &shadowRays[i], sizeof(RTCRay)), 0) << i;
    }
  }
}

// --- ways to trace -------------------------------------------------------------------------------------

TEST_F(VulkanTraces, RecordedTraceMatchesTraceFromHost) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  Random random(223);
  const std::vector<RTCRayHit> rays = raysAt(random, 333);
  const std::vector<RTCRayHit> expected = traceAll(uploaded.get(), rays);
  std::vector<RTCRay> shadowRays = withoutHits(rays), occluded = shadowRays;
  ASSERT_TRUE(trace(uploaded.get(), occluded));

  // both traces in one command buffer, with separate parts of the rays
  RecordedTrace recorded(vulkan->handles);
  RayBuffer closest(vulkan->handles, rays.data(), rays.size() * sizeof(RTCRayHit));
  RayBuffer any(vulkan->handles, shadowRays.data(), shadowRays.size() * sizeof(RTCRay));
  const size_t first = 64;
  recorded.record([&](VkCommandBuffer commands) {
    EXPECT_TRUE(rtcRecordVulkanIntersect(uploaded.get(), commands, closest.address, first));
    EXPECT_TRUE(rtcRecordVulkanIntersect(uploaded.get(), commands, closest.address + first * sizeof(RTCRayHit),
                                         rays.size() - first));
    EXPECT_TRUE(rtcRecordVulkanOccluded(uploaded.get(), commands, any.address, shadowRays.size()));
  });
  recorded.submitAndWait();
  EXPECT_EQ(std::memcmp(closest.mapped, expected.data(), expected.size() * sizeof(RTCRayHit)), 0);
  EXPECT_EQ(std::memcmp(any.mapped, occluded.data(), occluded.size() * sizeof(RTCRay)), 0);
}

TEST_F(VulkanTraces, SortedTraceMatchesUnsortedTrace) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  Random random(239);
  const std::vector<RTCRayHit> rays = raysAt(random, 5000); // more than one tile of the sort
  const std::vector<RTCRay> shadowRays = withoutHits(rays);
  std::vector<RTCRayHit> expected = rays;
  std::vector<RTCRay> occluded = shadowRays;
  ASSERT_TRUE(trace(uploaded.get(), expected) && trace(uploaded.get(), occluded)) << embree.message;

  RTCVulkanTraceTimes times;
  std::vector<RTCRayHit> sorted = rays;
  std::vector<RTCRay> sortedShadowRays = shadowRays;
  rtcSetVulkanSceneRaySorting(uploaded.get(), true);
  ASSERT_TRUE(trace(uploaded.get(), sorted, &times) && trace(uploaded.get(), sortedShadowRays)) << embree.message;
  EXPECT_TRUE(areSame(sorted, expected));
  EXPECT_TRUE(areSame(sortedShadowRays, occluded));
  EXPECT_GT(times.sortSeconds, 0);

  RecordedTrace recorded(vulkan->handles);
  const size_t bytes = rtcGetVulkanRayOrderBytes(rays.size());
  const std::vector<char> nothing(bytes, 0x55);
  RayBuffer closest(vulkan->handles, rays.data(), rays.size() * sizeof(RTCRayHit)),
      any(vulkan->handles, shadowRays.data(), shadowRays.size() * sizeof(RTCRay));
  RayBuffer orders[2] = {{vulkan->handles, nothing.data(), bytes}, {vulkan->handles, nothing.data(), bytes}};
  recorded.record([&](VkCommandBuffer commands) {
    EXPECT_TRUE(rtcRecordVulkanRayOrder(uploaded.get(), commands, closest.address, sizeof(RTCRayHit), rays.size(),
                                        orders[0].address));
    EXPECT_TRUE(
        rtcRecordVulkanIntersectInOrder(uploaded.get(), commands, closest.address, rays.size(), orders[0].address));
    EXPECT_TRUE(
        rtcRecordVulkanRayOrder(uploaded.get(), commands, any.address, sizeof(RTCRay), rays.size(), orders[1].address));
    EXPECT_TRUE(rtcRecordVulkanOccludedInOrder(uploaded.get(), commands, any.address, rays.size(), orders[1].address));
  });
  recorded.submitAndWait();
  EXPECT_EQ(std::memcmp(closest.mapped, expected.data(), expected.size() * sizeof(RTCRayHit)), 0);
  EXPECT_EQ(std::memcmp(any.mapped, occluded.data(), occluded.size() * sizeof(RTCRay)), 0);
}

TEST_F(VulkanTraces, SeveralTracesAreInFlight) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene), other = upload(scene, RTC_VULKAN_MEMORY_COPY);
  Random random(227);
  std::vector<std::vector<RTCRayHit>> rays;
  std::vector<RTCVulkanTrace> traces;
  for (int i = 0; i < 8; i++) {
    rays.push_back(raysAt(random, 40));
    std::vector<RTCRayHit> read = rays.back();
    traces.push_back(rtcStartVulkanIntersect(i % 2 ? uploaded.get() : other.get(), read.data(), read.size()));
    ASSERT_TRUE(traces.back()) << embree.message;
    std::memset(read.data(), 0xFF, read.size() * sizeof(RTCRayHit)); // the rays were already read
  }
  for (int i : {3, 7, 0, 1, 6, 5, 2, 4}) {
    std::vector<RTCRayHit> traced(rays[size_t(i)].size());
    while (i % 2 && !rtcIsVulkanTraceDone(traces[size_t(i)])) std::this_thread::yield();
    RTCVulkanTraceTimes times = {sizeof(times), -1, -1, -1};
    ASSERT_TRUE(rtcFinishVulkanTrace(traces[size_t(i)], traced.data(), &times)) << embree.message;
    EXPECT_GE(times.traceSeconds, 0);
    EXPECT_GE(times.copySeconds, 0);
    expectAsOnTheCPU(scene, rays[size_t(i)], traced);
  }
}

TEST_F(VulkanTraces, TracesCanBeReleasedWithoutWaiting) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  const RTCVulkanTrace trace = rtcStartVulkanIntersect(uploaded.get(), rays.data(), rays.size());
  EXPECT_TRUE(rtcFinishVulkanTrace(trace, nullptr, nullptr)) << embree.message;
}

TEST_F(VulkanTraces, ThreadsTraceOneSceneConcurrently) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  Random random(229);
  const std::vector<RTCRayHit> rays = raysAt(random, 100);
  std::vector<RTCRayHit> hits = rays;
  for (RTCRayHit& hit : hits) hit = intersect(scene, hit);
  std::vector<RTCRayHit> traced[2];
  bool alike[2] = {true, true};
  auto work = [&](int id) {
    for (int i = 0; i < 10; i++) {
      std::vector<RTCRayHit> mine = rays;
      std::vector<RTCRay> shadowRays = withoutHits(rays);
      alike[id] = alike[id] && trace(uploaded.get(), mine) && trace(uploaded.get(), shadowRays);
      for (size_t k = 0; k < rays.size(); k++) alike[id] = alike[id] && (shadowRays[k].tfar < 0) == isHit(mine[k]);
      alike[id] = alike[id] && (i == 0 || areSame(mine, traced[id]));
      traced[id] = mine;
      alike[id] = alike[id] && newVulkanScene(device, scene, RTC_VULKAN_MEMORY_COPY);
    }
  };
  std::thread one(work, 0), other(work, 1);
  one.join();
  other.join();
  EXPECT_TRUE(alike[0] && alike[1]) << embree.message;
  EXPECT_TRUE(areSame(traced[0], traced[1]));
  expectAsOnTheCPU(scene, rays, traced[0]);
}

}} // namespace programs::test
