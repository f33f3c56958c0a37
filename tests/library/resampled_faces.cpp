// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Faces of any edge rates, resampled to whole blocks: as close to the true surface as GRID with the same rates, with a
 * fraction of the memory. */

#include "kernels/cbvh/paper/frame_map.h"
#include "support/edge_rates.h"
#include "support/leaf_of_hit.h"
#include "support/memory.h"
#include "support/scene_blocks.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace programs::test { namespace {

std::vector<RTCRayHit> raysFromAround(Random& random, unsigned count) {
  std::vector<RTCRayHit> rays;
  for (unsigned i = 0; i < count; i++) {
    Vec o, d;
    for (int k = 0; k < 3; k++) o[k] = float(random.normal());
    const float length = std::sqrt(std::inner_product(o.begin(), o.end(), o.begin(), 0.0f));
    for (int k = 0; k < 3; k++) {
      o[k] *= 4 / length;
      d[k] = float(random.uniform(-0.5, 0.5)) - o[k];
    }
    rays.push_back(makeRay(o, d));
  }
  return rays;
}

// For rates that GRID resamples to the same multiples, vertices match GRID's except on borders to lower rates.
TEST(ResampledInterior, MatchesGridIfRatesAreMultiplesOfBlocks) {
  Device device;
  const Cage cage = cubeCage();
  Random random(63);
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.edgeRates = drawRates(cage, random, [](Random& r) { return float(16u << r.below(3)); });
  settings.compression = RTC_COMPRESSION_CGRID;
  const Twins twins(device, cage, settings);
  EXPECT_EQ(statisticsOf(twins.scene).numUncompressedQuads, 0u);
  const float quad = 1.0f / 16;
  unsigned interior = 0, borders = 0;
  for (const RTCRayHit& ray : raysFromAround(random, 20000)) {
    const RTCRayHit a = intersect(twins.grid, ray), b = intersect(twins.scene, ray);
    if (!isHit(a) || !isHit(b) || a.hit.primID != b.hit.primID) continue;
    // GRID stores parameters in 16 bits, and its fans at borders have the parameters of the edge
    ASSERT_LE(std::hypot(a.hit.u - b.hit.u, a.hit.v - b.hit.v), quad)
        << a.hit.u << " " << a.hit.v << ", " << b.hit.u << " " << b.hit.v;
    if (std::min({a.hit.u, a.hit.v, 1 - a.hit.u, 1 - a.hit.v}) < quad) {
      borders++;
      continue;
    }
    interior++;
    // the same test rounds differently in different compilations
    ASSERT_NEAR(a.ray.tfar, b.ray.tfar, 1e-5f) << a.hit.u << " " << a.hit.v;
    ASSERT_NEAR(a.hit.u, b.hit.u, 1e-4f);
    ASSERT_NEAR(a.hit.v, b.hit.v, 1e-4f);
  }
  EXPECT_GT(interior, 8000u);
  EXPECT_GT(borders, 500u);
}

class ResampledFaces : public testing::TestWithParam<RTCCompression> {};
INSTANTIATE_TEST_SUITE_P(Compression, ResampledFaces,
                         testing::Values(RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF), nameOf);

// cVERT has GRID's vertices for any rates.
class AnyRates : public ResampledFaces {};
INSTANTIATE_TEST_SUITE_P(Compression, AnyRates,
                         testing::Values(RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
                                         RTC_COMPRESSION_CVERT),
                         nameOf);

// True if a ray hits a much finer surface at a steep angle.
bool isSteep(const RTCRayHit& fine) {
  const float* N = &fine.hit.Ng_x;
  const float* D = &fine.ray.dir_x;
  const double nd = std::inner_product(N, N + 3, D, 0.0), nn = std::inner_product(N, N + 3, N, 0.0),
               dd = std::inner_product(D, D + 3, D, 0.0);
  return nd * nd >= 0.25 * nn * dd;
}

// Distance of a hit from that surface along its normal.
double distanceAcross(const RTCRayHit& fine, const RTCRayHit& hit) {
  const float* N = &fine.hit.Ng_x;
  const float* D = &fine.ray.dir_x;
  const double nd = std::inner_product(N, N + 3, D, 0.0), nn = std::inner_product(N, N + 3, N, 0.0);
  return std::fabs(hit.ray.tfar - fine.ray.tfar) * std::fabs(nd) / std::sqrt(nn);
}

/* Largest distance of the hit leaf from its quads, along the finer surface's normal: in cLEAF half its thickness,
 * measured in z of the frame; in cVOXEL and solid leaves, where rays hit boxes on entry, its extent. On borders, the
 * smallest value of the leaves there. */
double leafError(const std::vector<const embree::cbvh::Block*>& blocks, const RTCRayHit& fine, const RTCRayHit& hit) {
  using namespace embree::cbvh;
  const float* N = &fine.hit.Ng_x;
  const double n = std::sqrt(std::inner_product(N, N + 3, N, 0.0));
  double least = INFINITY;
  for (const LeafOfBlock& at : leavesOfHit(blocks, hit.hit)) {
    const Kind kind = at.block->kind();
    if (kind == Kind::CGRID) return 0;
    const LeafPatch leaf = decodeLeafOfBlock(at);
    const FrameMap map = frameMap(at.block);
    auto across = [&](double x, double y, double z) {
      Double3 p = {};
      EXPECT_TRUE(unproject(map, x, y, z, p));
      return (p.x * N[0] + p.y * N[1] + p.z * N[2]) / n;
    };
    const float *l = leaf.box.lower, *e = leaf.box.extent;
    double error;
    if (kind == Kind::CVOXEL || leaf.solid) {
      double lowest = INFINITY, highest = -INFINITY;
      for (int c = 0; c < 8; c++) {
        const double d = across(l[0] + (c & 1) * e[0], l[1] + ((c >> 1) & 1) * e[1], l[2] + (c >> 2) * e[2]);
        lowest = std::min(lowest, d);
        highest = std::max(highest, d);
      }
      error = highest - lowest;
    } else {
      const double x = l[0] + 0.5 * e[0], y = l[1] + 0.5 * e[1],
                   z = 0.25 * (leaf.z[0] + leaf.z[1] + leaf.z[2] + leaf.z[3]);
      error = std::fabs(across(x, y, z + 0.25 * leaf.thickness) - across(x, y, z - 0.25 * leaf.thickness));
    }
    least = std::min(least, error);
  }
  return least;
}

/* Resampling has finer quads inside and no fans at borders, so it does not increase the error, as cGRID shows. Leaves
 * of other kinds add half of their range on average, because quads are distributed evenly over it. */
TEST_P(ResampledFaces, SurfaceIsAsCloseToTrueOneAsGridExceptForLeafError) {
  Device device;
  for (const auto& set : rateSets) {
    SCOPED_TRACE(testing::Message() << "rates " << set.name);
    Random random(64);
    double ours = 0, grids = 0, allowed = 0;
    unsigned count = 0;
    for (const auto& cage : closedCages) {
      Displacement displacement;
      SurfaceSettings settings;
      settings.displacement = &displacement;
      settings.compression = RTC_COMPRESSION_NONE;
      settings.rate = 128;
      const SurfaceScene fine(device, cage.cage, settings);
      settings.edgeRates = drawRates(cage.cage, random, set.draw);
      settings.compression = GetParam() == RTC_COMPRESSION_CGRID ? RTC_COMPRESSION_NONE : RTC_COMPRESSION_CGRID;
      const SurfaceScene grid(device, cage.cage, settings);
      settings.compression = GetParam();
      const SurfaceScene scene(device, cage.cage, settings);
      const std::vector<const embree::cbvh::Block*> blocks = sceneBlocks(scene);
      for (const RTCRayHit& ray : raysFromAround(random, 2000)) {
        const RTCRayHit f = intersect(fine, ray), a = intersect(grid, ray), b = intersect(scene, ray);
        if (!isHit(f) || !isHit(a) || !isHit(b) || !isSteep(f)) continue;
        grids += distanceAcross(f, a);
        ours += distanceAcross(f, b);
        const double error = leafError(blocks, f, b);
        ASSERT_TRUE(std::isfinite(error))
            << "no leaf has these parameters: face " << b.hit.primID << ", " << b.hit.u << ", " << b.hit.v;
        allowed += 0.5 * error;
        count++;
      }
    }
    std::printf("%s, mean over %u hits: error %g, reference's %g, leaves may add %g\n", set.name, count, ours / count,
                grids / count, allowed / count);
    EXPECT_GT(count, 3000u);
    EXPECT_LE(ours / count, (grids + allowed) / count);
  }
}

TEST_P(ResampledFaces, EachOfTheFourEdgesDeterminesTheBlocks) {
  Device device;
  for (float rate : {16.0f, 64.0f, 300.0f})
    for (int frameLevel : {0, 1, RTC_COMPRESSION_FRAME_LEVEL_INHERIT, RTC_COMPRESSION_FRAME_LEVEL_AUTO}) {
      RTCCompressionStatistics stats[4];
      for (unsigned edge = 0; edge < 4; edge++) {
        SCOPED_TRACE(testing::Message() << "rate " << rate << " of edge " << edge << ", frame level " << frameLevel);
        SurfaceSettings settings;
        settings.compression = GetParam();
        settings.frameLevel = frameLevel;
        settings.edgeRates.assign(4, 4.0f);
        settings.edgeRates[edge] = rate;
        const SurfaceScene scene(device, quadCage(), settings);
        ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
        const RTCCompressionStatistics& s = stats[edge] = statisticsOf(scene);
        EXPECT_EQ(s.numUncompressedQuads > 0, rate > 256) << "faces with rates above 256 are left to GRID";
        EXPECT_EQ(s.numQuads > 0, rate <= 256);
        EXPECT_EQ(s.numBlocks, stats[0].numBlocks);
        EXPECT_EQ(s.numQuads, stats[0].numQuads);
        EXPECT_EQ(s.numUncompressedQuads, stats[0].numUncompressedQuads);
      }
    }
}

// The ratios are larger than at level 6, because most faces have a fraction of its quads.
TEST_P(AnyRates, MemoryIsAFractionOfGrid) {
  const double largestPart = GetParam() == RTC_COMPRESSION_CGRID    ? 0.65
                             : GetParam() == RTC_COMPRESSION_CVOXEL ? 0.14
                                                                    : 0.22;
  for (const auto& set : rateSets) {
    SCOPED_TRACE(testing::Message() << "rates " << set.name);
    ssize_t bytes[2];
    Random random(65);
    const Cage cage = sheetCage(32);
    Displacement displacement;
    SurfaceSettings settings;
    settings.displacement = &displacement;
    settings.edgeRates = drawRates(cage, random, set.draw);
    for (int i = 0; i < 2; i++) {
      Device device;
      Memory memory;
      rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
      settings.compression = i ? GetParam() : RTC_COMPRESSION_NONE;
      Scene scene(device);
      addSurface(device, scene, cage, settings);
      const ssize_t before = memory.live;
      rtcCommitScene(scene);
      bytes[i] = memory.live - before;
    }
    EXPECT_LE(bytes[1], bytes[0] * largestPart);
  }
}

// A box so flat that its sides have no usable frame. They store exact vertices, because GRID's borders differ.
TEST_P(ResampledFaces, BlocksWithoutFrameAreClosedToOthers) {
  Device device;
  Random random(67);
  Cage cage = cubeCage();
  for (Vec& p : cage.positions) p[1] *= 1e-5f;
  cage.mode = RTC_SUBDIVISION_MODE_PIN_ALL;
  SurfaceSettings settings;
  settings.edgeRates = drawRates(cage, random, rateSets[0].draw);
  settings.compression = GetParam();
  const SurfaceScene scene(device, cage, settings);
  const RTCCompressionStatistics stats = statisticsOf(scene);
  EXPECT_GT(stats.numQuads, 0u);
  EXPECT_EQ(stats.numUncompressedQuads, 0u);
  EXPECT_EQ(stats.numInvalidQuads, 0u);
  for (unsigned i = 0; i < 20000; i++) { // at a side, through the middle of its height
    const float z = float(random.uniform(-0.99, 0.99));
    const RTCRayHit hit = intersect(scene, makeRay({3, 0, z}, {-1, float(random.uniform(-2e-6, 2e-6)), 0}));
    ASSERT_TRUE(isHit(hit)) << z;
    ASSERT_NEAR(hit.ray.tfar, 2, GetParam() == RTC_COMPRESSION_CVOXEL ? 0.1 : 1e-3) << z;
  }
}

TEST_P(AnyRates, ChangedRatesAreRebuilt) {
  Device device;
  const Cage cage = prismCage(5);
  Random random(66);
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = GetParam();
  settings.edgeRates = drawRates(cage, random, rateSets[0].draw);
  Scene changing(device, RTC_SCENE_FLAG_DYNAMIC);
  const unsigned id = addSurface(device, changing, cage, settings);
  rtcCommitScene(changing);
  for (int step = 0; step < 4; step++) {
    settings.edgeRates = drawRates(cage, random, rateSets[step].draw);
    RTCGeometry geometry = rtcGetGeometry(changing, id);
    std::copy(settings.edgeRates.begin(), settings.edgeRates.end(),
              (float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_LEVEL, 0));
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_LEVEL, 0);
    rtcCommitGeometry(geometry);
    rtcCommitScene(changing);
    const SurfaceScene fresh(device, cage, settings);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_EQ(statisticsOf(changing).numQuads, statisticsOf(fresh).numQuads);
    unsigned hits = 0;
    for (const RTCRayHit& ray : raysFromAround(random, 2000)) {
      const RTCRayHit a = intersect(fresh, ray), b = intersect(changing, ray);
      ASSERT_EQ(isHit(a), isHit(b));
      if (!isHit(a)) continue;
      hits++;
      ASSERT_EQ(a.ray.tfar, b.ray.tfar);
      ASSERT_EQ(a.hit.primID, b.hit.primID);
    }
    EXPECT_GT(hits, 500u);
  }
}

}} // namespace programs::test
