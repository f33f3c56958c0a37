// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Random sizes, strides and vertices, mostly invalid. Valid grids are traced; errors are reported. Buffers end at most
 * 4 bytes after the range that the API requires, for sanitizers.
 *
 *   CBVH_RANDOM_GEOMETRIES=100000 random_grids    for a longer run */

#include "support/query_forms.h"
#include "support/random_rounds.h"

#include <algorithm>
#include <memory>

namespace programs::test { namespace {

struct RandomGrids {
  size_t numVertices, vertexStride, numGrids, gridStride;
  std::unique_ptr<char[]> vertices, grids; // each with 4 more bytes, which Embree may read after the last vertex

  explicit RandomGrids(Random& random)
    : numVertices(random.chance(0.1) ? random.below(4) : 1 + random.below(random.chance(0.2) ? 5000 : 200)),
      vertexStride(12 + 4 * random.below(3)),
      numGrids(random.chance(0.05) ? 0 : 1 + random.below(12)),
      gridStride(12 + 4 * random.below(2)),
      vertices(new char[numVertices * vertexStride + 4]),
      grids(new char[numGrids * gridStride + 4]) {
    const bool isPoisoned = random.chance(0.5);
    const double scale = random.magnitude(1e-6, 1e6);
    for (size_t i = 0; i < numVertices; i++) {
      float p[3] = {float(scale * (double(i % 16) + 0.3 * random.uniform())),
                    float(scale * (double(i / 16) + 0.3 * random.uniform())), float(scale * random.normal())};
      for (float& x : p) {
        if (random.chance(0.3)) x = std::nearbyint(x);
        if (isPoisoned && random.chance(0.01)) x = oddNumber(random);
      }
      std::memcpy(&vertices[i * vertexStride], p, sizeof(p));
    }
    for (size_t i = 0; i < numGrids; i++) {
      RTCGrid grid = {random.below(unsigned(numVertices) + 1), 1 + random.below(40), (unsigned short)random.below(30),
                      (unsigned short)random.below(30)};
      if (random.chance(0.5)) {
        grid.stride = 16;
        grid.width = (unsigned short)std::min<unsigned>(grid.width, 16);
      }
      if (random.chance(0.05)) grid.startVertexID = random.bits();
      if (random.chance(0.05)) grid.stride = random.chance(0.5) ? 0 : random.bits();
      if (random.chance(0.05)) (random.chance(0.5) ? grid.width : grid.height) = (unsigned short)random.bits();
      std::memcpy(&grids[i * gridStride], &grid, sizeof(grid));
    }
  }

  RTCGrid grid(size_t i) const {
    RTCGrid g;
    std::memcpy(&g, &grids[i * gridStride], sizeof(g));
    return g;
  }

  bool areSmall() const {
    size_t blocks = 0, embree = 0;
    for (size_t i = 0; i < numGrids; i++) {
      const RTCGrid g = grid(i);
      if (g.width < 2 || g.height < 2) continue;
      const size_t x = g.width - 1u, y = g.height - 1u;
      blocks += 130 * ((x + 15) / 16) * ((y + 15) / 16) + x * y;
      embree += 68 * ((x + 1) / 2) * ((y + 1) / 2);
    }
    return blocks > embree;
  }

  size_t quads(size_t i) const {
    const RTCGrid g = grid(i);
    return g.width > 1 && g.height > 1 ? (g.width - size_t(1)) * (g.height - size_t(1)) : 0;
  }

  // Grids without quads are right: Embree accepts them.
  bool isRight(size_t i) const {
    const RTCGrid g = grid(i);
    return quads(i) == 0 || uint64_t(g.startVertexID) + uint64_t(g.height - 1) * g.stride + g.width - 1 < numVertices;
  }

private:
  static float oddNumber(Random& random) {
    const float odd[] = {NAN, INFINITY, -INFINITY, 1e18f, -1e18f, 1e30f, 3e38f, 1e-40f, -0.0f, 1e-30f};
    return odd[random.below(sizeof(odd) / sizeof(*odd))];
  }
};

TEST(RandomGrids, AreTracedOrReported) {
  Random random(107);
  const size_t rounds = randomRounds(400);
  size_t hits = 0, named = 0, right = 0;
  for (size_t round = 0; round < rounds; round++) {
    SCOPED_TRACE(testing::Message() << "round " << round);
    Device device("threads=2");
    const RandomGrids grids(random);
    Scene scene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_GRID);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, grids.vertices.get(), 0,
                               grids.vertexStride, grids.numVertices);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, grids.grids.get(), 0,
                               grids.gridStride, grids.numGrids);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = RTC_COMPRESSION_CVERT;
    if (random.chance(0.3)) args.maxError = float(random.magnitude(1e-38, 1e38));
    // otherwise they would be left to Embree, which does not report errors
    const bool releases = random.chance(0.3) || grids.areSmall();
    if (releases) args.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT;
    rtcSetGeometryCompression(geometry, &args);
    rtcCommitGeometry(geometry);
    attach(scene, geometry);
    rtcCommitScene(scene);
    const RTCError error = device.takeError();

    size_t quads = 0, wrong = 0;
    for (size_t i = 0; i < grids.numGrids; i++)
      if (grids.isRight(i)) quads += grids.quads(i);
      else wrong++;
    ASSERT_TRUE(error == RTC_ERROR_NONE || error == RTC_ERROR_INVALID_ARGUMENT) << device.message;
    ASSERT_EQ(error != RTC_ERROR_NONE, wrong != 0);
    if (error) { ASSERT_NE(device.message.find("geometry 0, grid "), std::string::npos) << device.message; }
    const RTCCompressionStatistics stats = statisticsOf(scene);
    ASSERT_LE(stats.numQuads, quads);
    ASSERT_GE(stats.numQuads + stats.numInvalidQuads, quads);
    named += error != RTC_ERROR_NONE;
    right += grids.numGrids - wrong;

    std::vector<RTCRayHit> rays;
    RTCBounds bounds;
    rtcGetSceneBounds(scene, &bounds);
    if (quads && std::isfinite(bounds.lower_x) && bounds.upper_x - bounds.lower_x < 1e12f)
      for (int i = 0; i < 40; i++) {
        const auto in = [&](float a, float b) { return float(a + random.uniform() * (double(b) - a)); };
        const Vec at = {in(bounds.lower_x, bounds.upper_x), in(bounds.lower_y, bounds.upper_y),
                        in(bounds.lower_z, bounds.upper_z)};
        Vec direction;
        for (float& d : direction) d = random.chance(0.2) ? 0.0f : float(random.normal());
        rays.push_back(makeRay(at, direction));
      }
    if (rays.empty()) continue;
    for (QueryForm form : {QueryForm::Single, QueryForm::Packet8, QueryForm::CoherentStream}) {
      const std::vector<RTCRayHit> closest = closestHits(scene, rays, form), any = anyHits(scene, rays, form);
      for (size_t i = 0; i < rays.size(); i++) {
        ASSERT_EQ(isHit(closest[i]), any[i].ray.tfar < 0);
        if (!isHit(closest[i])) continue;
        hits++;
        const RTCHit& hit = closest[i].hit;
        ASSERT_EQ(hit.geomID, 0u);
        ASSERT_LT(hit.primID, grids.numGrids);
        ASSERT_TRUE(grids.isRight(hit.primID) && grids.quads(hit.primID) > 0);
        ASSERT_TRUE(hit.u >= 0 && hit.u <= 1 && hit.v >= 0 && hit.v <= 1) << hit.u << ' ' << hit.v;
      }
    }
  }
  EXPECT_GT(right, rounds / 2); // about one per round
  EXPECT_GT(named, rounds / 4);
  EXPECT_GT(hits, rounds);
}

}} // namespace programs::test
