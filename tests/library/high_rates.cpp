// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Edge rates above 256, up to Embree's 4096. cVERT supports them in strips, cLEAF as fallback faces. */

#include "support/edge_rates.h"
#include "support/memory.h"
#include "support/vert_triangles.h"

#include <atomic>
#include <cmath>

namespace programs::test { namespace {

// Over the unit square of quadCage; 0 at u = 0 and v = 0.
float heightAt(float u, float v) { return 0.1f * std::sin(9 * u) * std::sin(7 * v); }

void lift(const RTCDisplacementFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; i++) args->P_z[i] = heightAt(args->u[i], args->v[i]);
}

SurfaceSettings settingsOf(RTCCompression compression, Displacement* displacement) {
  SurfaceSettings settings;
  settings.compression = compression;
  settings.displacement = displacement;
  return settings;
}

class HighRates : public testing::TestWithParam<RTCCompression> {};
INSTANTIATE_TEST_SUITE_P(Compression, HighRates, testing::Values(RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CLEAF),
                         [](const auto& info) {
                           return std::string(info.param == RTC_COMPRESSION_CVERT ? "cVERT" : "cLEAF");
                         });

// Quads are at most 1/100 wide.
TEST_P(HighRates, DisplacedPlaneIsHitAtTheRightPlace) {
  Device device;
  for (const std::vector<float>& rates : {std::vector<float>{257, 257, 257, 257},
                                          {1000, 300, 1000, 300},
                                          {100, 4096, 100, 4096},
                                          {4096, 300, 100, 257}}) {
    SCOPED_TRACE(testing::Message() << "rates " << rates[0] << ", " << rates[1] << ", " << rates[2] << ", "
                                    << rates[3]);
    SurfaceSettings settings = settingsOf(GetParam(), nullptr);
    settings.fallbackFaces = true;
    settings.edgeRates = rates;
    const Scene scene(device);
    RTCGeometry geometry = newSurface(device, quadCage(), settings);
    rtcSetGeometryDisplacementFunction(geometry, lift);
    rtcCommitGeometry(geometry);
    attach(scene, geometry);
    rtcCommitScene(scene);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const RTCCompressionStatistics stats = statisticsOf(scene);
    EXPECT_EQ(stats.numUncompressedQuads, 0u);
    EXPECT_EQ(stats.numQuads, size_t(std::max(rates[0], rates[2])) * size_t(std::max(rates[1], rates[3])));
    Random random(111);
    for (int i = 0; i < 20000; i++) {
      const float x = float(random.uniform(0.02, 0.98)), y = float(random.uniform(0.02, 0.98));
      const RTCRayHit ray = makeRay({x, y, 1}, {0, 0, -1}), hit = intersect(scene, ray);
      ASSERT_TRUE(isHit(hit) && occluded(scene, ray)) << x << ", " << y;
      ASSERT_NEAR(1 - hit.ray.tfar, heightAt(x, y), 1e-3f);
      ASSERT_NEAR(hit.hit.u, x, 1e-3f);
      ASSERT_NEAR(hit.hit.v, y, 1e-3f);
    }
  }
}

// Also between the strips of a patch, and next to faces with other rates.
TEST(HighRatesOfCVERT, ClosedSurfacesShareEveryEdge) {
  Device device;
  const Cage cage = cubeCage();
  const auto highest = [](std::initializer_list<float> choice) {
    const std::vector<float> rates(choice);
    return [rates](Random& r) { return rates[r.below(unsigned(rates.size()))]; };
  };
  for (const auto& draw : {highest({1, 2, 280}), highest({1, 5, 1000}), highest({1, 3, 4096})}) {
    Random random(112);
    Displacement displacement;
    SurfaceSettings settings = settingsOf(RTC_COMPRESSION_CVERT, &displacement);
    settings.edgeRates = drawRates(cage, random, draw);
    // faces with two higher rates would have millions of quads; both sides of an edge may have different rates
    for (size_t first = 0; first < cage.indices.size(); first += 4) {
      float* rate = settings.edgeRates.data() + first;
      if (std::max(rate[0], rate[2]) > 300 && std::max(rate[1], rate[3]) > 300) rate[1] = rate[3] = 5;
    }
    const SurfaceScene scene(device, cage, settings);
    EXPECT_EQ(statisticsOf(scene).numUncompressedQuads, 0u);
    EXPECT_EQ(countOpenEdges(vertTriangles(scene)), 0u);
  }
}

// In addition to the result: a strip's vertices, the primitives of the top level, and up to 2 MiB that the BVH's
// allocator reserves. All of 4096 x 512 quads at once would take 112 MiB.
TEST(HighRatesOfCVERT, TaskUsesLessThan4MiB) {
  for (float across : {32.0f, 512.0f}) {
    Memory memory;
    Device device("threads=1");
    rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
    Displacement displacement;
    SurfaceSettings settings = settingsOf(RTC_COMPRESSION_CVERT, &displacement);
    settings.edgeRates = {4096, across, 4096, across};
    const SurfaceScene scene(device, quadCage(), settings);
    const ssize_t primitives = 64 * ssize_t(statisticsOf(scene).numBlocks);
    EXPECT_LT(memory.peak - memory.live, (6 << 20) + primitives) << across;
  }
}

}} // namespace programs::test
