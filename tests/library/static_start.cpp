// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* A program that contains the library's object files may use them in constructors of static objects, which run before
 * the library's own. */

#include "support/query_forms.h"
#include "support/scene.h"

#include <gtest/gtest.h>

#include <memory>

namespace cbvh::test {
namespace {

struct Traced
{
  size_t cacheBytes;
  std::vector<RTCRayHit> hits;
};

// Still and moving cages, and rays at them.
struct Scenes
{
  Device device;
  Displacement displacement;
  std::vector<std::unique_ptr<Scene>> scenes;

  Scenes()
  {
    for (RTCCompression compression : {RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVOXEL})
      for (unsigned timeSteps : {1u, 2u}) {
        if (timeSteps > 1 && compression != RTC_COMPRESSION_CVERT) continue;
        SurfaceSettings settings;
        settings.rate = 64;
        settings.displacement = &displacement;
        settings.compression = compression;
        settings.timeSteps = timeSteps;
        scenes.push_back(std::make_unique<SurfaceScene>(device, cubeCage(), settings));
      }
  }

  std::vector<Traced> trace() const
  {
    Random random(91);
    const std::vector<RTCRayHit> rays = raysAt(random, 2000);
    std::vector<Traced> all;
    for (const auto& scene : scenes)
      all.push_back({size_t(statisticsOf(*scene).cacheBytesPerThread), closestHits(*scene, rays, QueryForm::Single)});
    return all;
  }
};

const Scenes early;
const std::vector<Traced> tracedEarly = early.trace();

void expectSame(const std::vector<Traced>& a, const std::vector<Traced>& b)
{
  ASSERT_EQ(a.size(), b.size());
  for (size_t i = 0; i < a.size(); i++) {
    EXPECT_GT(b[i].cacheBytes, 0u);
    EXPECT_EQ(a[i].cacheBytes, b[i].cacheBytes) << "entries that only one of the two uses may be uninitialized";
    size_t hits = 0;
    for (size_t k = 0; k < a[i].hits.size(); k++) {
      hits += isHit(a[i].hits[k]);
      ASSERT_EQ(std::memcmp(&a[i].hits[k], &b[i].hits[k], offsetof(RTCRayHit, hit.instID)), 0) << "ray " << k;
    }
    EXPECT_GT(hits, 1000u);
  }
}

TEST(StaticStart, RaysOfConstructorsFindTheSameHits)
{
  expectSame(tracedEarly, early.trace());
  expectSame(tracedEarly, Scenes().trace());
}

} // namespace
} // namespace cbvh::test
