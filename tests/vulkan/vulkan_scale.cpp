// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Large scenes have the same hits on the device and on the CPU. */

#include "vulkan_tracer.h"

namespace programs::test { namespace {

class VulkanScale : public VulkanTest {
protected:
  Random random{91};
  Displacement displacement;

  SurfaceSettings settings(RTCCompression compression, float rate) {
    SurfaceSettings s;
    s.displacement = &displacement;
    s.compression = compression;
    s.frameLevel = 1;
    s.rate = rate;
    return s;
  }

  RTCVulkanSceneStatistics expectProcessorsHits(RTCScene scene, RTCVulkanMemory memory, size_t count) {
    const VulkanScene onDevice = newVulkanScene(device, scene, memory);
    RTCVulkanSceneStatistics statistics = {};
    EXPECT_NE(onDevice, nullptr) << embree.message;
    if (!onDevice) return statistics;
    rtcGetVulkanSceneStatistics(onDevice.get(), &statistics);
    const std::vector<RTCRayHit> rays = raysAt(random, unsigned(count), 1);
    std::vector<RTCRayHit> found = rays;
    intersectOnDevice(onDevice, found);
    size_t hits = 0, other = 0;
    for (size_t i = 0; i < count; i++) {
      const RTCRayHit truth = intersect(scene, rays[i]);
      hits += isHit(truth);
      other +=
          isHit(truth) != isHit(found[i]) ||
          (isHit(truth) && (truth.hit.geomID != found[i].hit.geomID || truth.hit.instID[0] != found[i].hit.instID[0]));
    }
    EXPECT_GT(hits, count / 10);
    EXPECT_LE(other, 1 + count / 10000);
    return statistics;
  }
};

TEST_F(VulkanScale, HundredThousandInstances) {
  Scene leaf(embree), scene(embree);
  addSurface(embree, leaf, cubeCage(), settings(RTC_COMPRESSION_CLEAF, 16));
  rtcCommitScene(leaf);
  for (int i = 0; i < 100000; i++) {
    RTCGeometry instance = rtcNewGeometry(embree, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, leaf);
    const float k = 0.01f, m[12] = {k,
                                    0,
                                    0,
                                    0,
                                    k,
                                    0,
                                    0,
                                    0,
                                    k,
                                    float(random.uniform(-2, 2)),
                                    float(random.uniform(-2, 2)),
                                    float(random.uniform(-2, 2))};
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, m);
    rtcCommitGeometry(instance);
    attach(scene, instance);
  }
  rtcCommitScene(scene);
  EXPECT_EQ(expectProcessorsHits(scene, RTC_VULKAN_MEMORY_AUTO, 10000).numInstances, 100000u);
}

TEST_F(VulkanScale, TenThousandGeometries) {
  Scene scene(embree);
  std::vector<Displacement> displacements(10000);
  for (size_t i = 0; i < displacements.size(); i++) {
    displacements[i].scale = 0.04f;
    displacements[i].offset = {float(random.uniform(-2, 2)), float(random.uniform(-2, 2)),
                               float(random.uniform(-2, 2))};
    SurfaceSettings s = settings(i % 2 ? RTC_COMPRESSION_CLEAF : RTC_COMPRESSION_CVERT, 2);
    s.displacement = &displacements[i];
    addSurface(embree, scene, cubeCage(), s);
  }
  rtcCommitScene(scene);
  for (RTCVulkanMemory memory : {RTC_VULKAN_MEMORY_AUTO, RTC_VULKAN_MEMORY_COPY})
    EXPECT_EQ(expectProcessorsHits(scene, memory, 5000).numGeometries, displacements.size());
}

// More than lavapipe's largest storage buffer, 128 MiB, and many pages of references.
TEST_F(VulkanScale, BlocksBeyondTheLargestBuffer) {
  const SurfaceScene scene(embree, sheetCage(35), settings(RTC_COMPRESSION_NONE, 64));
  const RTCVulkanSceneStatistics copied = expectProcessorsHits(scene, RTC_VULKAN_MEMORY_COPY, 20000);
  EXPECT_GT(copied.deviceBytes, size_t(128) << 20);
  EXPECT_EQ(copied.importedBytes, 0u);
  if (!vulkan->handles.hasHostImport) return;
  const RTCVulkanSceneStatistics imported = expectProcessorsHits(scene, RTC_VULKAN_MEMORY_IMPORT, 20000);
  EXPECT_GT(imported.importedBytes, size_t(128) << 20);
  EXPECT_LT(imported.deviceBytes, copied.deviceBytes);
}

}} // namespace programs::test
