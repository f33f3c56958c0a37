// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Whether rays have the same hits on the device as on the processor. */

#include "small_scenes.h"
#include "vulkan_tracer.h"

#include <algorithm>

namespace cbvh::test {

// What was compared, and what was not the same.
struct Agreement
{
  size_t rays = 0, hits = 0;
  size_t otherHit = 0;    // a hit for a miss, or the other way round
  size_t otherPlace = 0;  // other IDs, or farther apart than a hundredth of what a quad of 1/64 is wide
  size_t otherNormal = 0; // at the same place, as on the edge of two triangles
  size_t otherAny = 0;    // any hit is not what closest hit is

  // One ray in 10^5, as where a ray grazes an edge; rays of tests are fewer.
  void expect() const
  {
    EXPECT_GT(hits, rays/10) << "the rays miss";
    EXPECT_LE(otherHit, rays/100000 + 1);
    EXPECT_LE(otherPlace, hits/10000 + 2);
    EXPECT_LE(otherNormal, hits/1000 + 2);
    EXPECT_EQ(otherAny, 0u);
  }
};

class VulkanAgreement : public VulkanTest
{
protected:
  Random random{71};

  void compare(RTCScene scene, const std::vector<RTCRayHit>& rays, Agreement& sum, RTCVulkanMemory memory = RTC_VULKAN_MEMORY_AUTO)
  {
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
      if (isHit(truth) != isHit(found[i])) { sum.otherHit++; continue; }
      if (!isHit(truth)) continue;
      const double n = std::sqrt(double(a.Ng_x)*a.Ng_x + double(a.Ng_y)*a.Ng_y + double(a.Ng_z)*a.Ng_z);
      const double dn = std::max({std::fabs(a.Ng_x - b.Ng_x), std::fabs(a.Ng_y - b.Ng_y), std::fabs(a.Ng_z - b.Ng_z)});
      const double dt = std::fabs(double(truth.ray.tfar) - found[i].ray.tfar);
      const bool isOther = a.geomID != b.geomID || a.primID != b.primID || a.instID[0] != b.instID[0] || dt > 1e-5*truth.ray.tfar
        || std::max(std::fabs(a.u - b.u), std::fabs(a.v - b.v)) > 1e-3;
      sum.otherPlace += isOther;
      sum.otherNormal += !isOther && dn > 1e-2*n;
    }
  }
};

} // namespace cbvh::test
