// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares traces of blocks of all difficult shapes, sizes and positions on the device with the scalar reference, by
 * the same check as for the ISAs of the CPU (support/reference_check.h). */

#include "support/reference_check.h"
#include "vulkan_tracer.h"

namespace programs::test { namespace {

class VulkanReference : public VulkanTest {
protected:
  void expectReferences(RTCCompression compression) {
    ReferenceCheck check(
        embree, compression, [&](RTCScene scene, std::vector<RTCRayHit>& closest, std::vector<RTCRay>& any) {
          const VulkanScene onDevice =
              newVulkanScene(device, scene, ++scenes % 2 ? RTC_VULKAN_MEMORY_COPY : RTC_VULKAN_MEMORY_AUTO);
          intersectOnDevice(onDevice, closest);
          occludedOnDevice(onDevice, any);
        });
    Random random(61);
    const std::vector<Placement> placements = {
        {1, {0, 0, 0}}, {1e-6, {0, 0, 0}}, {1e6, {0, 0, 0}}, {1, {1000, -2000, 500}}};
    for (unsigned height : {0, 1, 2, 3, 5})
      for (const Placement& at : placements)
        for (Shape shape : allShapes) {
          check.trace(random, randomSheet(random, shape, height, at), allRays, 8, scenes % 3 != 0);
          if (HasFatalFailure()) return;
        }
    check.conclude(0.7);
  }

private:
  unsigned scenes = 0;
};

TEST_F(VulkanReference, GridsMatchReference) { expectReferences(RTC_COMPRESSION_CGRID); }
TEST_F(VulkanReference, VoxelsMatchReference) { expectReferences(RTC_COMPRESSION_CVOXEL); }
TEST_F(VulkanReference, LeavesMatchReference) { expectReferences(RTC_COMPRESSION_CLEAF); }
TEST_F(VulkanReference, VerticesMatchReference) { expectReferences(RTC_COMPRESSION_CVERT); }
TEST_F(VulkanReference, TilesMatchReference) { expectReferences(RTC_COMPRESSION_CTILE); }

}} // namespace programs::test
