// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Loaded geometry has the same hits on the device as before it was saved: in compute shaders, with copied and with
 * mapped blocks, and in ray queries. */

#include "small_scenes.h"
#include "vulkan_tracer.h"
#include "support/moving_surface.h"
#include "support/saved.h"
#include "support/surface_access.h"

namespace programs::test { namespace {

class VulkanFiles : public VulkanTest {
protected:
  Random random{103};

  std::vector<RTCRayHit> traced(const VulkanScene& scene, const std::vector<RTCRayHit>& rays) {
    EXPECT_NE(scene, nullptr) << embree.message;
    return scene ? traceAll(scene.get(), rays) : std::vector<RTCRayHit>();
  }
};

TEST_F(VulkanFiles, LoadedGeometryHasTheSameHits) {
  const Folder folder;
  std::string refused; // memory that the driver did not import; imports of mapped files are optional
  const std::string path = folder / "surface.cbvh";
  for (const Saveable& form : allSaveable()) {
    SCOPED_TRACE(form.name);
    Scene saved(embree), loaded(embree);
    RTCGeometry geometry = form.make(embree);
    saveGeometryFile(geometry, path.c_str());
    ASSERT_EQ(embree.takeError(), RTC_ERROR_NONE) << embree.message;
    attach(saved, geometry);
    RTCGeometry from = loadGeometryFile(embree, path.c_str());
    ASSERT_NE(from, nullptr) << embree.message;
    rtcCommitGeometry(from);
    attach(loaded, from);
    rtcCommitScene(saved);
    rtcCommitScene(loaded);

    const std::vector<RTCRayHit> rays = timedRays(random, 1000);
    const VulkanScene scene = newVulkanScene(device, saved);
    if (!scene && std::string(form.name).find("irregular") != std::string::npos) {
      EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_OPERATION);
      EXPECT_NE(embree.message.find("mesh"), std::string::npos) << embree.message;
      continue;
    }
    const std::vector<RTCRayHit> expected = traced(scene, rays);
    size_t hits = 0;
    for (const RTCRayHit& ray : expected) hits += isHit(ray);
    EXPECT_GT(hits, rays.size() / 20);
    EXPECT_TRUE(areSame(expected, traced(newVulkanScene(device, loaded, RTC_VULKAN_MEMORY_COPY), rays)));
    EXPECT_TRUE(areSame(expected, traced(newVulkanScene(device, loaded), rays)));
    if (vulkan->handles.hasHostImport) {
      const VulkanScene imported = newVulkanScene(device, loaded, RTC_VULKAN_MEMORY_IMPORT);
      if (imported) {
        EXPECT_TRUE(areSame(expected, traced(imported, rays)));
      } else {
        EXPECT_EQ(embree.takeError(), RTC_ERROR_OUT_OF_MEMORY);
        EXPECT_NE(embree.message.find("importing"), std::string::npos) << embree.message;
        refused = std::string(form.name) + ": " + embree.message;
      }
    }
    if (!vulkan->handles.hasRayQuery) continue;
    const std::vector<RTCRayHit> byQuery = traced(newQueryScene(device, loaded), rays);
    size_t others = 0;
    for (size_t i = 0; i < rays.size() && i < byQuery.size(); i++)
      others += std::memcmp(&expected[i], &byQuery[i], sizeof(RTCRayHit)) != 0;
    EXPECT_LE(others, 1u); // blocks of cVOXEL overlap
  }
  if (!refused.empty() && !HasFailure())
    GTEST_SKIP() << "hits of copied blocks are the same, but the driver does not import " << refused;
}

}} // namespace programs::test
