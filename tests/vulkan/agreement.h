// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Compares hits of the same rays on the device and on the CPU. */

#include "small_scenes.h"
#include "vulkan_tracer.h"

#include <algorithm>

namespace programs::test {

struct Agreement {
  size_t rays = 0, hits = 0;
  size_t otherHit = 0;    // a hit instead of a miss, or the reverse
  size_t otherPlace = 0;  // different IDs, a t that differs by more than 1e-5 of it, or u or v by more than 1e-3
  size_t otherNormal = 0; // at the same position, for example on the edge of two triangles
  size_t otherAny = 0;    // any hit differs from closest hit

  // Allows a few differences, for example of rays that graze an edge.
  void expect() const {
    EXPECT_GT(hits, rays / 10) << "too many rays miss";
    EXPECT_LE(otherHit, rays / 100000 + 1);
    EXPECT_LE(otherPlace, hits / 10000 + 2);
    EXPECT_LE(otherNormal, hits / 1000 + 2);
    EXPECT_EQ(otherAny, 0u);
  }
};

class VulkanAgreement : public SharedVulkanTest {
protected:
  Random random{71};

  void compare(RTCScene scene, const std::vector<RTCRayHit>& rays, Agreement& sum,
               RTCVulkanMemory memory = RTC_VULKAN_MEMORY_AUTO) {
    ASSERT_EQ(embree.takeError(), RTC_ERROR_NONE) << embree.message;
    const VulkanScene onDevice = newVulkanScene(device, scene, memory);
    ASSERT_NE(onDevice, nullptr) << embree.message;
    std::vector<RTCRayHit> found = rays;
    std::vector<RTCRay> any;
    for (const RTCRayHit& ray : rays) any.push_back(ray.ray);
    intersectOnDevice(onDevice, found);
    occludedOnDevice(onDevice, any);
    for (size_t i = 0; i < rays.size(); i++) {
      const RTCRayHit truth = intersect(scene, rays[i]);
      const RTCHit &a = truth.hit, &b = found[i].hit;
      sum.rays++;
      sum.hits += isHit(truth);
      sum.otherAny += (any[i].tfar < 0) != isHit(found[i]);
      if (isHit(truth) != isHit(found[i])) {
        sum.otherHit++;
        continue;
      }
      if (!isHit(truth)) continue;
      const double n = std::sqrt(double(a.Ng_x) * a.Ng_x + double(a.Ng_y) * a.Ng_y + double(a.Ng_z) * a.Ng_z);
      const double dn = std::max({std::fabs(a.Ng_x - b.Ng_x), std::fabs(a.Ng_y - b.Ng_y), std::fabs(a.Ng_z - b.Ng_z)});
      const double dt = std::fabs(double(truth.ray.tfar) - found[i].ray.tfar);
      const bool isOther = a.geomID != b.geomID || a.primID != b.primID || a.instID[0] != b.instID[0] ||
                           dt > 1e-5 * truth.ray.tfar || std::max(std::fabs(a.u - b.u), std::fabs(a.v - b.v)) > 1e-3;
      sum.otherPlace += isOther;
      sum.otherNormal += !isOther && dn > 1e-2 * n;
    }
  }
};

} // namespace programs::test
