// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Shaders access memory only inside of buffers, by the validation layer's instrumentation. It makes shaders many times
 * larger: lavapipe compiles cVERT's for four minutes, too long for a test, and the others in seconds. */

#include "recorded_trace.h"
#include "small_scenes.h"

#include <algorithm>

namespace programs::test { namespace {

class VulkanBounds : public VulkanTest {
protected:
  void SetUp() override {
    useCacheFolderOfTests();
    if (const std::string reason = ValidatedDevice::missing(); !reason.empty()) GTEST_SKIP() << reason;
    if (!Validation::isInstalled()) GTEST_SKIP() << "no validation layer";
    DeviceOptions options;
    options.isGpuAssisted = true;
    vulkan = std::make_unique<ValidatedDevice>(options);
    device = open(vulkan->handles);
    ASSERT_TRUE(device) << embree.message;
  }
};

TEST_F(VulkanBounds, ScenesAreAccessedWithinBounds) {
  Scene scene(embree), surfaces(embree);
  Displacement displacements[4];
  Random random(233);
  std::vector<RTCRayHit> rays;
  int i = 0;
  for (RTCCompression compression :
       {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF}) {
    const float x = 3.0f * float(i);
    SurfaceSettings settings = smallSurface(compression);
    settings.displacement = &displacements[i];
    displacements[i].offset = {x, 0, 0};
    addSurface(embree, surfaces, sheetCage(4), settings);
    for (int k = 0; k < 200; k++)
      rays.push_back(makeRay({x + float(random.uniform(-1, 1)), float(random.uniform(-1, 1)), 2},
                             {float(random.uniform(-0.1, 0.1)), float(random.uniform(-0.1, 0.1)), -1}));
    i++;
  }
  attach(surfaces, newTriangle(embree, 1));
  rtcCommitScene(surfaces);
  attach(scene, newInstance(embree, surfaces, 0.25f));
  attach(scene, newTriangle(embree, 1.5f));
  rtcCommitScene(scene);

  for (RTCVulkanMemory memory : {RTC_VULKAN_MEMORY_COPY, RTC_VULKAN_MEMORY_AUTO}) {
    const VulkanScene uploaded = newVulkanScene(device, scene, memory);
    ASSERT_TRUE(uploaded) << embree.message;
    std::vector<RTCRayHit> traced = rays, sorted = rays;
    ASSERT_TRUE(trace(uploaded.get(), traced)) << embree.message;
    rtcSetVulkanSceneRaySorting(uploaded.get(), true);
    ASSERT_TRUE(trace(uploaded.get(), sorted)) << embree.message;
    EXPECT_TRUE(areSame(traced, sorted));
    EXPECT_GT(std::count_if(traced.begin(), traced.end(), isHit), 600);
  }
}

}} // namespace programs::test
