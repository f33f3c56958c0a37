// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Rays from inside a closed surface hit it: closest and any hit, single rays and coherent packets, for each
 * representation and any levels, also far from the origin. Most aim at vertices on common borders (leak_rays.h) that
 * the displacement function returns, so they are exactly on the surface.
 *
 * Embree's triangle test misses some of those rays, because it rounds edges differently in their two triangles. cGRID,
 * which uses it, may miss as many rays as GRID. Other representations must miss none. cVERT moves vertices, except for
 * those that are already on its lattice. (Stock GRID misses 1 to 5 percent of these rays.) */

#include "basics/parallel.h"
#include "measure/leak_rays.h"
#include "support/vert_triangles.h"
#include "support/vertex_recorder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <tuple>

namespace programs::test { namespace {

constexpr size_t raysOfCase = 60000; // more than 10^6 per representation, twice
constexpr uint32_t seed = 51;

// Edges of quads after displacement.
struct AimPointRecorder : public VertexRecorder {
  const Cage* cage = nullptr;
  unsigned level = 0, frameLevel = 0;
  AimPoints points;

  void record(const RTCDisplacementFunctionNArguments& args) override {
    for (unsigned i = 0; i + 1 < args.N; i++)
      if (args.v[i] == args.v[i + 1]) add(args, i);
  }

  // Adds an edge of a quad along u, in alternating directions.
  void add(const RTCDisplacementFunctionNArguments& args, unsigned i) {
    const auto at = [&](unsigned k) { return Vec3f{args.P_x[k], args.P_y[k], args.P_z[k]}; };
    const unsigned a = i + (i & 1), b = i + 1 - (i & 1);
    const AimPoint point = {at(a), at(b), {args.Ng_x[i], args.Ng_y[i], args.Ng_z[i]}};
    const bool isQuad = cage->faces[args.primID] == 4;
    const long size = long(1) << (isQuad ? level : level - 1), block = std::max(1l, long(1) << level >> frameLevel);
    // corner i of an n-gon covers [0.5,1.5] + 2 (i mod 4, i div 4)
    const auto local = [&](float u) {
      return std::lround((isQuad ? u : u - 0.5f - 2 * std::floor(0.5f * u)) * float(size));
    };
    const long x = local(args.u[a]), y = local(args.v[a]);
    const bool onU = x % size == 0, onV = y % size == 0;
    points[onU && onV                         ? AtCageVertex
           : onU || onV                       ? AtFaceBorder
           : x % block == 0 || y % block == 0 ? AtBlockBorder
                                              : AtVertex]
        .push_back(point);
  }

  AimPoints taken() {
    const auto key = [](const AimPoint& p) {
      return std::make_tuple(p.position.x, p.position.y, p.position.z, p.neighbor.x, p.neighbor.y, p.neighbor.z);
    };
    for (std::vector<AimPoint>& kind : points)
      std::sort(kind.begin(), kind.end(), [&](const AimPoint& a, const AimPoint& b) { return key(a) < key(b); });
    return points;
  }
};

struct Case {
  const char* name;
  Cage cage;
  unsigned level;
  int frameLevel;
  float scale;
  Vec offset;
  bool mixed;  // the frame level differs between faces, because of an error bound
  bool coarse; // a quad is a few ulps wide: faces round shared vertices by a part of a quad
};

std::vector<Case> cases() {
  const Vec origin = {0, 0, 0}, far = {148376, 1234, -223423};
  Cage creased = cubeCage();
  creased.creases = {{0, 1}, {1, 3}, {3, 2}, {2, 0}};
  creased.creaseWeights = {INFINITY, 2.5f, 0.7f, INFINITY};
  std::vector<Case> list;
  for (unsigned level = 3; level <= 7; level++)
    for (int frameLevel : {0, 2, int(level)})
      list.push_back({"cube", cubeCage(), level, frameLevel, 1, origin, false, false});
  list.push_back({"triangles", prismCage(3), 4, 1, 1, origin, false, false});
  list.push_back({"pentagons", prismCage(5), 4, 2, 1, origin, false, false});
  list.push_back({"heptagons", prismCage(7), 5, 2, 1, origin, false, false});
  list.push_back({"valence 9", trapezohedronCage(9), 4, 2, 1, origin, false, false});
  list.push_back({"creases", creased, 5, 2, 1, origin, false, false});
  list.push_back({"far", cubeCage(), 5, 2, 1, far, false, true});
  list.push_back({"far and wide", cubeCage(), 4, 1, 1000, far, false, false});
  list.push_back({"tiny", cubeCage(), 4, 1, 1e-6f, origin, false, false});
  list.push_back(
      {"mixed frame levels", trapezohedronCage(5), 5, RTC_COMPRESSION_FRAME_LEVEL_AUTO, 1, origin, true, false});
  return list;
}

class Watertight : public testing::TestWithParam<RTCCompression> {
protected:
  static void expectNoLeaks(const LeakCounts& counts, const Case& c) {
    EXPECT_GT(counts.aimed, raysOfCase / 4);
    EXPECT_EQ(counts.sceneLeaks.any, counts.sceneLeaks.closest);
    const bool mayLeak = GetParam() == RTC_COMPRESSION_CGRID;
    // equal except for chance: a vertex that rounds differently moves a leak
    const auto allowed = [&](size_t ofGrid) {
      return mayLeak ? double(ofGrid) + 5 * std::sqrt(double(ofGrid)) + 5 : 0;
    };
    EXPECT_LE(double(counts.sceneLeaks.closest), allowed(counts.gridLeaks.closest));
    EXPECT_LE(double(counts.sceneLeaks.through), allowed(counts.gridLeaks.through));
    if (mayLeak && !c.coarse) { EXPECT_EQ(counts.random.closest, 0u); }
    for (const Ray& r : counts.examples)
      if (!mayLeak)
        ADD_FAILURE() << "leaks from " << r.origin.x << " " << r.origin.y << " " << r.origin.z << " towards "
                      << r.direction.x << " " << r.direction.y << " " << r.direction.z;
  }
};

TEST_P(Watertight, RaysFromInsideHit) {
  Device device;
  size_t rays = 0;
  for (const Case& c : cases()) {
    SCOPED_TRACE(testing::Message() << c.name << ", level " << c.level << ", frame level " << c.frameLevel << ", seed "
                                    << seed);
    AimPointRecorder recorder;
    recorder.scale = c.scale;
    recorder.offset = c.offset;
    recorder.cage = &c.cage;
    // an eighth of a quad, a multiple of cVERT's spacing: cVERT stores exactly these vertices, at which rays aim
    if (GetParam() == RTC_COMPRESSION_CVERT)
      recorder.lattice = std::ldexp(1.0f, std::ilogb(c.scale) - 2 - int(c.level));
    recorder.level = c.level;
    recorder.frameLevel = unsigned(std::max(c.frameLevel, 0));
    SurfaceSettings settings;
    settings.displacement = &recorder;
    settings.rate = float(1u << c.level);
    settings.frameLevel = c.frameLevel;
    if (c.mixed) settings.maxError = 0.004f * c.scale;
    settings.compression = GetParam();
    const SurfaceScene scene(device, c.cage, settings);
    settings.compression = RTC_COMPRESSION_NONE;
    Scene grid(device);
    recorder.build(device, grid, c.cage, settings);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;

    if (c.coarse && GetParam() == RTC_COMPRESSION_CVERT) {
      // gaps of GRID are nearly as large as a quad here, so it cannot decide which points are inside
      EXPECT_EQ(countOpenEdges(vertTriangles(scene)), 0u);
      continue;
    }
    LeakSettings leakSettings;
    leakSettings.rays = raysOfCase;
    const RTCCompressionStatistics stats = statisticsOf(scene);
    if (!c.mixed && !c.coarse) { EXPECT_EQ(stats.maxVertexDeviation, 0); }
    leakSettings.thickness = std::max(stats.maxLeafThickness, stats.maxVertexDeviation + stats.maxBorderMismatch);
    leakSettings.seed = seed;
    const AimPoints points = recorder.taken();
    ASSERT_FALSE(points[AtCageVertex].empty());
    const EmbreeTracer single(scene);
    const PacketTracer packets(scene);
    for (const bool inPackets : {false, true}) {
      SCOPED_TRACE(inPackets ? "packets" : "single rays");
      const SceneTracer& tracer = inPackets ? (const SceneTracer&)packets : single;
      const LeakCounts counts = countLeaks(grid, tracer, points, leakSettings, threadCount(0));
      rays += counts.rays;
      expectNoLeaks(counts, c);
    }
  }
  EXPECT_GE(rays, 2000000u);
}

std::string nameOf(const testing::TestParamInfo<RTCCompression>& info) { return kindName(info.param); }

INSTANTIATE_TEST_SUITE_P(Compression, Watertight,
                         testing::Values(RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
                                         RTC_COMPRESSION_CVERT),
                         nameOf);

}} // namespace programs::test
