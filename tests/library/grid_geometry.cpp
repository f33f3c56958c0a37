// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compressed grid geometry: hits match Embree's kernel with every function and on every ISA; grids stay closed and
 * stitched. */

#include "support/closed.h"
#include "support/diced.h"
#include "support/memory.h"
#include "support/message_parts.h"
#include "support/same_hits.h"
#include "support/surface_access.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <mutex>
#include <set>
#include <unistd.h>

namespace programs::test { namespace {

// Odd sizes, strides larger than the width, and a first vertex other than 0.
Diced oddGrids(double lattice) {
  Diced diced = dicedSheet(1, 37, lattice);
  const Diced sheet = diced;
  diced.grids.clear();
  const unsigned side = 38,
                 sizes[][4] = {
                     {0, 0, 37, 7}, {0, 7, 5, 30}, {5, 7, 1, 30}, {6, 7, 31, 29}, {6, 36, 31, 1}}; // x, y, quads
  for (const auto& s : sizes)
    diced.grids.push_back({s[1] * side + s[0], side, (unsigned short)(s[2] + 1), (unsigned short)(s[3] + 1)});
  return diced;
}

class GridGeometry : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Isas, GridGeometry, testing::Values(TEST_ISAS), nameOfIsa);

TEST_P(GridGeometry, HitsMatchEmbree) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(101);
  const double lattice = 0x1p-10;
  const struct {
    const char* name;
    Diced diced;
  } shapes[] = {{"one grid", dicedSheet(1, 64, lattice)},
                {"a grid of 1000 quads a side", dicedSheet(1, 1000, 0x1p-14)},
                {"small grids", dicedSheet(9, 4, lattice)},
                {"grids of 8 quads", dicedSheet(5, 8, lattice)},
                {"grids of 16 quads", dicedSheet(3, 16, lattice)},
                {"grids of 33 quads", dicedSheet(2, 33, lattice)},
                {"odd grids", oddGrids(lattice)}};
  for (const auto& shape : shapes) {
    SCOPED_TRACE(shape.name);
    const GridScene embree(device, shape.diced, RTC_COMPRESSION_NONE), scene(device, shape.diced);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const RTCCompressionStatistics stats = statisticsOf(scene);
    ASSERT_EQ(stats.numQuads, shape.diced.quads());
    ASSERT_EQ(stats.maxVertexDeviation, 0) << "all vertices are on the lattice";
    ASSERT_EQ(statisticsOf(embree).numQuads, 0u);
    ASSERT_NO_FATAL_FAILURE(expectSameQueries(embree, scene, raysAt(random, shape.diced, 1003)));
  }
}

// Two geometries of grids next to a subdivision surface, also in an instance.
TEST_P(GridGeometry, MixedScenesMatchEmbree) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(102);
  const Diced diced = dicedSheet(4, 12, 0x1p-10);
  const auto fill = [&](RTCScene scene, RTCCompression compression) {
    Diced below = diced;
    for (Vec& p : below.vertices) p[2] -= 0.5f;
    rtcAttachGeometryByID(scene, newGrids(device, diced, compression), 5);
    rtcAttachGeometryByID(scene, newGrids(device, below, compression), 2);
    rtcReleaseGeometry(rtcGetGeometry(scene, 5));
    rtcReleaseGeometry(rtcGetGeometry(scene, 2));
    SurfaceSettings settings;
    settings.compression = RTC_COMPRESSION_CVERT;
    Cage sheet = sheetCage(2);
    for (Vec& p : sheet.positions) p[2] += 0.75f;
    addSurface(device, scene, sheet, settings);
    rtcCommitScene(scene);
  };
  Scene embree(device), scene(device);
  fill(embree, RTC_COMPRESSION_NONE);
  fill(scene, RTC_COMPRESSION_CVERT);
  Scene instances[2] = {Scene(device), Scene(device)};
  for (int i = 0; i < 2; i++) {
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, i ? scene : embree);
    const float transform[12] = {0, 1, 0, -1, 0, 0, 0, 0, 1, 0, 0.25f, 0};
    rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
    rtcCommitGeometry(instance);
    attach(instances[i], instance);
    rtcCommitScene(instances[i]);
  }
  ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  const std::vector<RTCRayHit> rays = raysAt(random, diced, 503);
  std::set<unsigned> found;
  for (const RTCRayHit& ray : rays) found.insert(intersect(embree, ray).hit.geomID);
  expectSameQueries(embree, scene, rays);
  expectSameQueries(instances[0], instances[1], rays);
  EXPECT_EQ(found.count(5) + found.count(2), 2u);
}

TEST_P(GridGeometry, MasksAndFilters) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  const Diced diced = dicedSheet(2, 20);
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  RTCGeometry geometry = newGrids(device, diced, RTC_COMPRESSION_CVERT);
  attach(scene, geometry);
  rtcCommitScene(scene);
  RTCRayHit down = makeRay({0.3f, 0.2f, 5}, {0, 0, -1});
  const float depth = intersect(scene, down).ray.tfar;
  ASSERT_LT(depth, 5.2f);
  EXPECT_TRUE(occluded(scene, down));

  // Changed vertices without an update are visible only if blocks are rebuilt.
  float* x = (float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  for (size_t i = 0; i < diced.vertices.size(); i++) x[3 * i + 2] -= 1;
  rtcSetGeometryMask(geometry, 2);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(intersect(scene, down).ray.tfar, depth) << "a mask must not cause a rebuild";
  down.ray.mask = 1;
  EXPECT_FALSE(isHit(intersect(scene, down)));
  EXPECT_FALSE(occluded(scene, down));
  down.ray.mask = 2;
  EXPECT_TRUE(isHit(intersect(scene, down)));
  EXPECT_TRUE(occluded(scene, down));

  rtcSetGeometryIntersectFilterFunction(geometry, [](const RTCFilterFunctionNArguments* args) { args->valid[0] = 0; });
  rtcSetGeometryOccludedFilterFunction(geometry, [](const RTCFilterFunctionNArguments* args) { args->valid[0] = 0; });
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_FALSE(isHit(intersect(scene, down)));
  EXPECT_FALSE(occluded(scene, down));
  rtcSetGeometryIntersectFilterFunction(geometry, nullptr);
  rtcSetGeometryOccludedFilterFunction(geometry, nullptr);
  rtcDisableGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_FALSE(isHit(intersect(scene, down)));
  rtcEnableGeometry(geometry);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(intersect(scene, down).ray.tfar, depth);

  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_NEAR(intersect(scene, down).ray.tfar, depth + 1, 1e-3) << "vertices";
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// --- closed -----------------------------------------------------------------------------------

TEST(GridSurfaces, AreClosedBetweenGrids) {
  Device device;
  Random random(103);
  const struct {
    unsigned n, quads;
    double warp;
  } balls[] = {{3, 3, 1}, {3, 4, 1}, {3, 7, 1}, {3, 16, 1}, {3, 40, 1}, {8, 5, 3}, {5, 16, 3}};
  for (const auto& b : balls) {
    SCOPED_TRACE(testing::Message() << b.n << " x " << b.n << " grids of " << b.quads << " quads, warped by "
                                    << b.warp);
    const Diced ball = dicedBall(b.n, b.quads, b.warp);
    const GridScene scene(device, ball);
    EXPECT_GT(statisticsOf(scene).maxVertexDeviation, 0);
    if (b.warp == 1) { EXPECT_EQ(statisticsOf(scene).numRawBlocks, 0u) << "quads have the same size"; }
    std::vector<RTCRayHit> rays;
    for (unsigned i = 0; i < 30000; i++) {
      const RTCGrid& grid = ball.grids[random.below(unsigned(ball.grids.size()))];
      const bool alongU = random.chance(0.5);
      const unsigned n = (alongU ? grid.width : grid.height) - 1u, k = random.below(n),
                     other = random.chance(0.5) ? 0 : (alongU ? grid.height : grid.width) - 1u;
      const Vec &a = alongU ? ball.vertex(grid, k, other) : ball.vertex(grid, other, k),
                &b = alongU ? ball.vertex(grid, k + 1, other) : ball.vertex(grid, other, k + 1);
      rays.push_back(rayFromMiddle(random, a, b));
    }
    expectNoneMisses(scene, rays);
  }
}

// A coarse grid, and finer ones whose border vertices lie on its edges: two grids in a row.
Diced stitchedGrids(unsigned coarse, unsigned fine) {
  Diced diced;
  const auto height = [](double x, double y) { return 0.2 * std::sin(5 * x + 1) * std::cos(4 * y); };
  diced.add(coarse + 1, coarse + 1, [&](unsigned x, unsigned y) {
    const double u = double(x) / coarse - 1, v = double(y) / coarse;
    return Vec{float(u), float(v), float(height(u, v))};
  });
  const RTCGrid first = diced.grids[0];
  for (unsigned part = 0; part < 2; part++)
    diced.add(fine + 1, fine + 1, [&](unsigned x, unsigned y) {
      const double u = double(x) / fine, v = (part + double(y) / fine) / 2;
      if (x > 0) return Vec{float(u), float(v), float(height(u, v))};
      const unsigned k = std::min(unsigned(v * coarse), coarse - 1);
      const Vec a = diced.vertex(first, coarse, k), b = diced.vertex(first, coarse, k + 1);
      const double t = v * coarse - k;
      Vec p;
      for (int c = 0; c < 3; c++) p[c] = t == 0 ? a[c] : t == 1 ? b[c] : float(a[c] + t * (double(b[c]) - a[c]));
      return p;
    });
  return diced;
}

TEST(GridSurfaces, StayStitched) {
  Device device;
  Random random(104);
  const unsigned counts[][2] = {{2, 4}, {4, 12}, {8, 32}, {5, 5}, {20, 60}, {16, 8}};
  for (const auto& n : counts) {
    SCOPED_TRACE(testing::Message() << n[0] << " and 2 x " << n[1] << " quads");
    const Diced diced = stitchedGrids(n[0], n[1]);
    const GridScene embree(device, diced, RTC_COMPRESSION_NONE), scene(device, diced);
    const bool mayBeLeft = n[0] == 2; // without AVX, Embree's own form of so small grids is smaller
    if (!mayBeLeft || statisticsOf(scene).numBlocks > 0) {
      EXPECT_LT(statisticsOf(scene).numRawBlocks, statisticsOf(scene).numBlocks)
          << "raw blocks occur only along the seam";
    }
    size_t missed = 0, missedByEmbree = 0;
    for (unsigned i = 0; i < 20000; i++) {
      const unsigned k = random.below(n[0]);
      const Vec a = diced.vertex(diced.grids[0], n[0], k), b = diced.vertex(diced.grids[0], n[0], k + 1);
      const double t = random.uniform();
      Vec from = {float(0.5 * random.normal()), float(0.5 + 0.5 * random.normal()), 3}, direction;
      for (int c = 0; c < 3; c++)
        direction[c] = float(a[c] + t * (b[c] - a[c]) + (c == 0 ? 1e-3 * random.normal() / n[1] : 0)) - from[c];
      if (t < 1e-3 && k == 0) continue; // the end of the seam
      const RTCRayHit ray = makeRay(from, direction);
      missed += !isHit(intersect(scene, ray));
      missedByEmbree += !isHit(intersect(embree, ray));
    }
    EXPECT_LE(missed, missedByEmbree + 3);
  }
}

// A closed box. Its sides are strips of 1 x 16 quads, `fine` per edge of the top and the bottom. All border vertices
// are shared, also by the two strips that meet on such an edge.
Diced boxOfStrips(unsigned coarse, unsigned fine) {
  Diced box;
  for (double z : {-1.0, 1.0})
    box.add(coarse + 1, coarse + 1, [&](unsigned x, unsigned y) {
      const double u = 2.0 * x / coarse - 1, v = 2.0 * y / coarse - 1;
      return Vec{float(u + 0.03 * std::sin(9 * v)), float(v), float(z + 0.1 * std::sin(7 * u + 3 * v))};
    });
  const auto onRing = [&](const RTCGrid& end, unsigned k) {
    const unsigned side = k / coarse % 4, along = k % coarse;
    return side == 0   ? box.vertex(end, along, 0)
           : side == 1 ? box.vertex(end, coarse, along)
           : side == 2 ? box.vertex(end, coarse - along, coarse)
                       : box.vertex(end, 0, coarse - along);
  };
  const auto lerp = [](const Vec& a, const Vec& b, double t) {
    Vec p;
    for (int c = 0; c < 3; c++) p[c] = t == 0 ? a[c] : t == 1 ? b[c] : float(a[c] + t * (double(b[c]) - a[c]));
    return p;
  };
  const RTCGrid bottom = box.grids[0], top = box.grids[1];
  for (unsigned strip = 0; strip < 4 * coarse * fine; strip++)
    box.add(2, 17, [&](unsigned x, unsigned y) {
      const unsigned k = (strip + x) / fine;
      const double t = double((strip + x) % fine) / fine;
      return lerp(lerp(onRing(bottom, k), onRing(bottom, k + 1), t), lerp(onRing(top, k), onRing(top, k + 1), t),
                  y / 16.0);
    });
  return box;
}

TEST(GridSurfaces, StayStitchedIfAllVerticesAreShared) {
  Device device;
  Random random(106);
  for (unsigned fine : {2, 3, 5}) {
    SCOPED_TRACE(testing::Message() << fine << " strips per edge");
    const unsigned coarse = 6;
    const Diced box = boxOfStrips(coarse, fine);
    const GridScene scene(device, box);
    ASSERT_EQ(statisticsOf(scene).numQuads, box.quads());
    size_t missed = 0;
    for (unsigned i = 0; i < 40000; i++) {
      const unsigned k = random.below(coarse), border = random.chance(0.5) ? 0 : coarse;
      const RTCGrid& end = box.grids[random.below(2)];
      const bool alongX = random.chance(0.5);
      const RTCRayHit ray = alongX ? rayFromMiddle(random, box.vertex(end, k, border), box.vertex(end, k + 1, border))
                                   : rayFromMiddle(random, box.vertex(end, border, k), box.vertex(end, border, k + 1));
      missed += !isHit(intersect(scene, ray));
    }
    EXPECT_LE(missed, 3u) << "of 40000 rays at the seams; floats between two vertices may be off their edge";
  }
}

// Returns the stored vertices of each grid, row by row, at a time from 0 to 1; NaN where none is stored.
std::vector<std::vector<Vec>> storedVertices(RTCGeometry geometry, const std::vector<RTCGrid>& grids, float time) {
  struct Found {
    const std::vector<RTCGrid>& grids;
    std::vector<std::vector<Vec>> vertices;
  } found{grids, {}};
  for (const RTCGrid& grid : grids) found.vertices.emplace_back(size_t(grid.width) * grid.height, Vec{NAN, NAN, NAN});
  forEachStoredPart(
      geometry, time,
      [](void* ptr, const CbvhPart* part) {
        const RTCGrid& grid = ((Found*)ptr)->grids.at(part->primID);
        for (unsigned i = 0; i < part->width * part->height; i++) {
          const auto x = size_t(std::lround(part->parameters[2 * i] * float(grid.width - 1))),
                     y = size_t(std::lround(part->parameters[2 * i + 1] * float(grid.height - 1)));
          std::copy_n(part->vertices + 3 * i, 3, ((Found*)ptr)->vertices[part->primID].at(y * grid.width + x).begin());
        }
        return true;
      },
      &found);
  return found.vertices;
}

// A coarse sheet next to a fine one. Every second border vertex of the fine one is `aside` above the coarse edge.
TEST(GridSurfaces, StitchedVerticesKeepMaxError) {
  const unsigned n = 16;
  for (const double aside : {0.009, 0.006, 0.001, 1e-4, 0.0})
    for (const float maxError : {-1.0f, 16.0f, 0.02f, 0.01f, 0x1p-10f}) {
      SCOPED_TRACE(testing::Message() << aside << " above the edge, max_error " << maxError);
      Device device;
      Diced diced;
      const auto height = [](double x, double y) { return float(100 * std::sin(x / 3000) * std::cos(y / 2000)); };
      diced.add(n + 1, n + 1, [&](unsigned x, unsigned y) {
        return Vec{1024.0f * float(x), 1024 * (float(y) - n), y == n ? 0 : height(1024 * x, 1024.0 * (y - double(n)))};
      });
      diced.add(2 * n + 1, 2 * n + 1, [&](unsigned x, unsigned y) {
        return Vec{512.0f * float(x), 512.0f * float(y), y == 0 ? x % 2 ? float(aside) : 0 : height(512 * x, 512 * y)};
      });
      RTCGeometry geometry = newGridsOf(device, diced.grids, {diced.vertices}, RTC_COMPRESSION_CVERT, 0, maxError);
      Scene scene(device);
      rtcAttachGeometry(scene, geometry);
      rtcCommitScene(scene);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      const auto stored = storedVertices(geometry, diced.grids, 0);
      double most = 0;
      for (size_t grid = 0; grid < 2; grid++) {
        const Vec* given = &diced.vertices[diced.grids[grid].startVertexID];
        for (size_t i = 0; i < stored[grid].size(); i++) {
          double square = 0;
          for (int k = 0; k < 3; k++) {
            const double moved = double(stored[grid][i][k]) - given[i][k];
            square += moved * moved;
          }
          ASSERT_FALSE(std::isnan(square)) << "grid " << grid << ", vertex " << i;
          most = std::max(most, std::sqrt(square));
        }
      }
      if (maxError > 0) { EXPECT_LE(most, maxError); }
      EXPECT_NEAR(statisticsOf(scene).maxVertexDeviation, most, 1e-6 * most);
      EXPECT_EQ(statisticsOf(scene).maxBorderMismatch, 0);
      if (maxError < 0 || maxError > 1) {
        for (unsigned x = 1; x < 2 * n; x += 2) EXPECT_EQ(stored[1][x][2], 0) << "stitched, at x = " << x;
      }
      rtcReleaseGeometry(geometry);
    }
}

// Grids of different sizes share border vertices. One of them is NaN at the first step.
TEST(GridSurfaces, MovingGridsShareVerticesThatAreNotFiniteAtSomeStep) {
  Device device;
  Diced diced;
  const unsigned n = 8;
  for (const double width : {10.0, -1.0})
    diced.add(n + 1, n + 1, [&](unsigned x, unsigned y) {
      return Vec{float(width * x / n + 0.013 * y), float(width * 0.1 * y), float(0.1 * std::sin(2.0 * y + 0.3 * x))};
    });
  for (unsigned y = 0; y <= n; y++) diced.vertex(diced.grids[1], 0, y) = diced.vertex(diced.grids[0], 0, y);
  const auto verticesAt = [&](unsigned step) {
    std::vector<Vec> moved = diced.vertices;
    for (Vec& p : moved) p[2] += 0.037f * float(step);
    if (step == 0)
      for (const RTCGrid& grid : diced.grids) moved[grid.startVertexID + 4 * grid.stride][2] = NAN;
    return moved;
  };
  RTCGeometry geometry =
      newGridsOf(device, diced.grids, {verticesAt(0), verticesAt(1), verticesAt(2)}, RTC_COMPRESSION_CVERT);
  Scene scene(device);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  for (const float time : {0.5f, 1.0f}) {
    const auto stored = storedVertices(geometry, diced.grids, time);
    for (unsigned y = 0; y <= n; y++)
      for (int k = 0; k < 3; k++)
        EXPECT_EQ(stored[0][y * (n + 1)][k], stored[1][y * (n + 1)][k])
            << "row " << y << ", axis " << k << " at " << time;
  }
  rtcReleaseGeometry(geometry);
}

// Position of a vertex of a strip at a time step. x: -1, 0 or 1. aside: distance from the seam.
typedef std::function<Vec(double x, double aside, unsigned step)> StripMotion;

// Strips of 1 x 8 quads with two time steps, as two surfaces.
struct MovingStrips {
  Diced steps[2];

  void add(double x0, double x1, double aside, const StripMotion& place) {
    for (unsigned step = 0; step < 2; step++)
      steps[step].add(2, 9, [&](unsigned x, unsigned y) { return place(x ? x1 : x0, aside * y, step); });
  }

  // Returns the stored vertices of each strip at the second step. The order of grids may be reversed.
  std::vector<std::vector<Vec>> stored(RTCDevice device, bool reversed) const {
    std::vector<RTCGrid> grids = steps[0].grids;
    if (reversed) std::reverse(grids.begin(), grids.end());
    RTCGeometry geometry = newGridsOf(device, grids, {steps[0].vertices, steps[1].vertices}, RTC_COMPRESSION_CVERT);
    Scene scene(device);
    attach(scene, geometry);
    rtcCommitScene(scene);
    auto vertices = storedVertices(geometry, grids, 1);
    if (reversed) std::reverse(vertices.begin(), vertices.end());
    return vertices;
  }
};

// Vertices that are equal at the first time step only have different entries, whose order depends on the order of grids
// and on threads.
TEST(GridSurfaces, StitchedVerticesAreIndependentOfTheOrderOfGrids) {
  Device device("threads=1");
  const Vec middle = {1.013f, 0.017f, 0.029f};
  const auto expectSame = [&](const MovingStrips& strips) {
    const auto stored = strips.stored(device, false);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_EQ(stored, strips.stored(device, true));
  };
  MovingStrips crossing; // a vertex on two edges, which are equal at the first step
  for (int axis : {1, 2}) {
    const StripMotion turn = [&](double x, double aside, unsigned step) {
      const double angle = 0.3 * step;
      Vec p = middle;
      p[0] += float(x * std::cos(angle) - aside * std::sin(angle));
      p[axis] += float(x * std::sin(angle) + aside * std::cos(angle));
      return p;
    };
    crossing.add(-1, 1, -0.1, turn);
    crossing.add(-1, 0, 0.1, turn);
    crossing.add(0, 1, 0.1, turn);
  }
  expectSame(crossing);
  MovingStrips parting; // two vertices on an edge, which are equal at the first step
  for (int axis : {1, 2}) {
    const StripMotion part = [&](double x, double aside, unsigned step) {
      Vec p = middle;
      p[0] += float(0.97 * x);
      p[1] += float(0.31 * x);
      p[axis] += float(aside) + (axis == 2 && x == 0 && aside == 0 && step == 1 ? 8e-6f : 0.0f);
      return p;
    };
    if (axis == 1) parting.add(-1, 1, -0.1, part);
    parting.add(-1, 0, 0.1, part);
    parting.add(0, 1, 0.1, part);
  }
  expectSame(parting);
}

// --- errors -----------------------------------------------------------------------------------

TEST(GridSurfaces, InvalidGridsAreLeftOutAndReportedIfVerticesAreMissing) {
  Device device;
  const Diced good = dicedSheet(2, 8, 0x1p-10);
  const RTCRayHit atThird = makeRay({-0.5f, 0.5f, 5}, {0, 0, -1}), atFirst = makeRay({-0.5f, -0.5f, 5}, {0, 0, -1});
  const auto commit = [&](const Diced& diced) {
    const GridScene scene(device, diced);
    EXPECT_TRUE(isHit(intersect(scene, atFirst)));
    EXPECT_FALSE(isHit(intersect(scene, atThird)));
    return device.takeError();
  };
  const auto expectNamed = [&](const Diced& diced) {
    device.message.clear();
    EXPECT_EQ(commit(diced), RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_NE(device.message.find("geometry 0, grid 2"), std::string::npos) << device.message;
  };
  Diced outside = good;
  outside.grids[2].startVertexID = unsigned(good.vertices.size()) - 5;
  expectNamed(outside);
  outside = good;
  outside.grids[2].stride = 0xFFFFFFF0u; // computed in 32 bits, the last vertex is in the buffer
  expectNamed(outside);
  Diced line = good;
  line.grids[2].width = 1;
  EXPECT_EQ(commit(line), RTC_ERROR_NONE) << "accepted, as in Embree: " << device.message;
  Diced poisoned = good;
  for (unsigned y = 3; y < 7; y++)
    for (unsigned x = 3; x < 7; x++) poisoned.vertex(good.grids[2], x, y)[(x + y) % 3] = x % 2 ? INFINITY : NAN;
  EXPECT_EQ(commit(poisoned), RTC_ERROR_NONE) << "accepted, as in Embree: " << device.message;
  // the quads around, and grids without such a vertex, must exist
  const GridScene scene(device, poisoned);
  device.takeError();
  EXPECT_TRUE(isHit(intersect(scene, makeRay({-0.95f, 0.05f, 5}, {0, 0, -1}))));
  EXPECT_EQ(statisticsOf(scene).numInvalidQuads, 25u);
}

// --- settings ---------------------------------------------------------------------------------

TEST(GridSurfaces, CompressionCanBeSelected) {
  const Diced diced = dicedSheet(2, 20);
  const auto quads = [&](const Device& device, RTCCompression compression) {
    const GridScene scene(device, diced, compression);
    return statisticsOf(scene).numQuads;
  };
  Device plain, ofString("subdiv_accel=cbvh.leaf");
  EXPECT_EQ(quads(plain, RTC_COMPRESSION_INHERIT), 0u);
  EXPECT_EQ(quads(plain, RTC_COMPRESSION_CVERT), 1600u);
  EXPECT_EQ(quads(plain, RTC_COMPRESSION_CLEAF), 1600u) << "diced geometry is stored as cVERT";
  EXPECT_EQ(quads(ofString, RTC_COMPRESSION_INHERIT), 1600u);
  EXPECT_EQ(quads(ofString, RTC_COMPRESSION_NONE), 0u);
  EXPECT_EQ(plain.takeError(), RTC_ERROR_NONE) << plain.message;

  // A dynamic scene that switches back and forth.
  Scene scene(plain, RTC_SCENE_FLAG_DYNAMIC);
  RTCGeometry geometry = newGrids(plain, diced);
  attach(scene, geometry);
  const RTCRayHit down = makeRay({0.3f, 0.2f, 5}, {0, 0, -1});
  for (RTCCompression compression : {RTC_COMPRESSION_NONE, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_NONE,
                                     RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CVERT}) {
    RTCCompressionArguments args;
    rtcInitCompressionArguments(&args);
    args.compression = compression;
    rtcSetGeometryCompression(geometry, &args);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    EXPECT_EQ(statisticsOf(scene).numQuads, compression == RTC_COMPRESSION_CVERT ? 1600u : 0u);
    EXPECT_TRUE(isHit(intersect(scene, down)));
  }
  EXPECT_EQ(plain.takeError(), RTC_ERROR_NONE) << plain.message;
}

// Embree stores a grid of 2 x 2 quads in 68 bytes, less than any block.
TEST(GridSurfaces, SmallestGridsAreNotCompressed) {
  Device device;
  Diced diced = dicedSheet(10, 2);
  const RTCRayHit down = makeRay({0.33f, 0.21f, 5}, {0, 0, -1});
  const auto quads = [&](unsigned flags) {
    Scene scene(device);
    attach(scene, newGrids(device, diced, RTC_COMPRESSION_CVERT, flags));
    rtcCommitScene(scene);
    EXPECT_TRUE(isHit(intersect(scene, down)));
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    return statisticsOf(scene).numQuads;
  };
  EXPECT_EQ(quads(0), 0u);
  EXPECT_EQ(quads(RTC_COMPRESSION_FLAG_RELEASE_INPUT), 400u) << "releasing their vertices saves more";
  diced.add(21, 21, [](unsigned x, unsigned y) { return Vec{0.1f * float(x), 0.1f * float(y), -1}; });
  EXPECT_EQ(quads(0), 0u) << "most grids are small";
  diced.add(201, 201, [](unsigned x, unsigned y) { return Vec{0.01f * float(x), 0.01f * float(y), -1}; });
  EXPECT_EQ(quads(0), 400u + 400 + 40000);
}

// Each later step of a block has a header of its own, while Embree's grids refer to the buffers of all steps.
TEST(GridSurfaces, LaterStepsCountAgainstCompression) {
  Device device;
  Diced diced = dicedSheet(10, 4);
  diced.motion = [](const Vec& p, unsigned step) { return Vec{p[0], p[1], p[2] + 0.01f * float(step)}; };
  const auto movingQuads = [&](unsigned flags, unsigned timeSteps) {
    Scene scene(device);
    attach(scene, newGrids(device, diced, RTC_COMPRESSION_CVERT, flags, timeSteps));
    rtcCommitScene(scene);
    EXPECT_TRUE(isHit(intersect(scene, makeRay({0.33f, 0.21f, 5}, {0, 0, -1}))));
    EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    return statisticsOf(scene).numMovingQuads;
  };
  EXPECT_EQ(movingQuads(0, 2), 1600u);
  EXPECT_EQ(movingQuads(0, 10), 0u);
  EXPECT_EQ(movingQuads(RTC_COMPRESSION_FLAG_RELEASE_INPUT, 10), 1600u) << "releasing their vertices saves more";
}

// Sides with more than 46,341 vertices: the product of two such numbers exceeds 2^31.
TEST(GridSurfaces, LongSidesAreHit) {
  for (const auto& [width, height] : {std::make_pair(50000u, 3u), std::make_pair(3u, 50000u),
                                      std::make_pair(65535u, 2u), std::make_pair(46342u, 18u)}) {
    SCOPED_TRACE(testing::Message() << width << " x " << height);
    Device device;
    Diced diced;
    diced.grids.push_back({0, width, (unsigned short)width, (unsigned short)height});
    for (unsigned y = 0; y < height; y++)
      for (unsigned x = 0; x < width; x++) diced.vertices.push_back({float(x), float(y), 0});
    const GridScene scene(device, diced);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_EQ(statisticsOf(scene).numQuads, size_t(width - 1) * (height - 1));
    Random random(9);
    for (int i = 0; i < 2000; i++) {
      const float x = float(random.uniform(0.01, width - 1.01)), y = float(random.uniform(0.01, height - 1.01));
      const RTCRayHit hit = intersect(scene, makeRay({x, y, 5}, {0, 0, -1}));
      ASSERT_TRUE(isHit(hit)) << x << ", " << y;
      ASSERT_NEAR(hit.ray.tfar, 5, 1e-3) << x << ", " << y;
      ASSERT_NEAR(hit.hit.u * float(width - 1), x, 0.02) << x << ", " << y;
      ASSERT_NEAR(hit.hit.v * float(height - 1), y, 0.02) << x << ", " << y;
    }
  }
}

TEST(GridSurfaces, RowsOfIdenticalVerticesAreErrors) {
  Device device;
  Diced diced = dicedSheet(2, 16);
  diced.grids.push_back({0, 0, 65535, 65535});
  for (unsigned i = 0; i < 65535; i++) diced.vertices.push_back({0, 0, 0});
  rtcReleaseGeometry(newGrids(device, diced, RTC_COMPRESSION_CVERT));
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(containsInOrder(device.message, {"grid 4 ", "65535", "65535", "stride", " 0", " 1"}));
}

// Four billion quads of 131,069 vertices.
TEST(GridSurfaces, CommitOfOverlappingRowsCanBeCancelled) {
  Device device;
  Diced diced;
  diced.grids.push_back({0, 1, 65535, 65535});
  for (unsigned i = 0; i < 2 * 65535u - 1; i++) diced.vertices.push_back({float(i), float(i % 7), 0});
  RTCGeometry geometry = newGrids(device, diced);
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  std::atomic<unsigned> calls(0);
  args.compression = RTC_COMPRESSION_CVERT;
  args.flags = RTC_COMPRESSION_FLAG_RELEASE_INPUT;
  args.progressUserPtr = &calls;
  args.progress = [](void* calls, double) { return ++*(std::atomic<unsigned>*)calls < 4; };
  rtcSetGeometryCompression(geometry, &args);
  alarm(120);
  rtcCommitGeometry(geometry);
  alarm(0);
  EXPECT_EQ(device.takeError(), RTC_ERROR_CANCELLED) << device.message;
  EXPECT_GE(calls, 4u);
  rtcReleaseGeometry(geometry);
}

TEST(GridSurfaces, InputIsReleased) {
  Memory memory;
  Device device;
  rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
  const Diced diced = dicedSheet(4, 64);
  const ssize_t before = memory.live;
  RTCGeometry geometry = newGrids(device, diced, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_FLAG_RELEASE_INPUT);
  Scene scene(device);
  rtcAttachGeometry(scene, geometry);
  rtcCommitScene(scene);
  EXPECT_LT(double(memory.live - before), 3.5 * double(diced.quads()));
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  const RTCRayHit down = makeRay({0.3f, 0.2f, 5}, {0, 0, -1});
  const RTCRayHit hit = intersect(scene, down);
  EXPECT_TRUE(isHit(hit));
  float P[3];
  rtcInterpolate0(geometry, hit.hit.primID, hit.hit.u, hit.hit.v, RTC_BUFFER_TYPE_VERTEX, 0, P, 3);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION);
  rtcSetGeometryMask(geometry, 2);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_EQ(intersect(scene, down).ray.tfar, hit.ray.tfar);
  rtcSetGeometryVertexAttributeCount(geometry, 0);
  rtcCommitGeometry(geometry);
  EXPECT_EQ(device.takeError(), RTC_ERROR_INVALID_OPERATION) << "there is no input";
  setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, diced.vertices);
  setBuffer(geometry, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, diced.grids);
  rtcCommitGeometry(geometry);
  rtcCommitScene(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_EQ(intersect(scene, down).ray.tfar, hit.ray.tfar);
  rtcReleaseGeometry(geometry);
}

TEST(GridSurfaces, CommitsReportProgressAndCanBeCancelled) {
  Device device;
  const Diced diced = dicedSheet(60, 8);
  struct Monitor {
    size_t calls = 0, last = ~size_t(0);
    double most = 0;
    std::mutex mutex;
  } monitor;
  const auto report = [](void* self, double done) {
    Monitor& m = *(Monitor*)self;
    const std::lock_guard<std::mutex> lock(m.mutex);
    m.most = std::max(m.most, done);
    return ++m.calls < m.last;
  };
  Scene scene(device);
  attach(scene, newGrids(device, diced, RTC_COMPRESSION_CVERT));
  rtcSetSceneProgressMonitorFunction(scene, report, &monitor);
  monitor.last = 3;
  rtcCommitScene(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_CANCELLED);
  monitor.last = ~size_t(0);
  monitor.most = 0;
  rtcCommitScene(scene);
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  EXPECT_GT(monitor.most, 0.99);
  EXPECT_LE(monitor.most, 1.0);
  EXPECT_EQ(statisticsOf(scene).numQuads, diced.quads());
}

// All bytes of the library including its tree, without the application's vertices.
TEST(GridSurfaces, MemoryIsSmall) {
  const struct {
    unsigned n, quads;
    double bytes;
  } sizes[] = {{400, 4, 12}, {100, 8, 6}, {32, 16, 3.5}, {8, 64, 3.5}, {1, 500, 3.5}};
  for (const auto& s : sizes) {
    Memory memory;
    Device device;
    rtcSetDeviceMemoryMonitorFunction(device, Memory::monitor, &memory);
    const Diced diced = dicedSheet(s.n, s.quads);
    Scene scene(device);
    RTCGeometry geometry = newGrids(device, diced, RTC_COMPRESSION_CVERT);
    attach(scene, geometry);
    const ssize_t before = memory.live;
    rtcCommitScene(scene);
    const double bytes = double(memory.live - before) / double(diced.quads());
    const RTCCompressionStatistics stats = statisticsOf(scene);
    const auto perQuad = [&](size_t n) { return double(n) / double(diced.quads()); };
    std::printf(
        "%u x %u grids of %u x %u quads: %.2f bytes per quad (%.2f tree, %.2f headers, %.2f groups, %.2f vertices), "
        "%.2f more during the build\n",
        s.n, s.n, s.quads, s.quads, bytes, perQuad(stats.topLevelBytes), perQuad(stats.headerBytes),
        perQuad(stats.nodeBytes), perQuad(stats.leafBytes), perQuad(size_t(memory.peak - memory.live)));
    EXPECT_LE(bytes, s.bytes) << s.quads << " quads";
  }
}

// --- point queries ----------------------------------------------------------------------------

TEST(GridSurfaces, PointQueriesMatchEmbree) {
  Device device;
  Random random(105);
  const Diced diced = dicedSheet(6, 9);
  const GridScene embree(device, diced, RTC_COMPRESSION_NONE), scene(device, diced);
  // Distance to the nearest vertex of a primitive, by which the query shrinks.
  struct Found {
    const Diced* diced;
    Vec at;
    unsigned primID = RTC_INVALID_GEOMETRY_ID;
    size_t calls = 0;
  };
  const auto nearest = [&](RTCScene in, const Vec& at, float radius) {
    Found found{&diced, at};
    RTCPointQuery query;
    query.x = at[0];
    query.y = at[1];
    query.z = at[2];
    query.time = 0;
    query.radius = radius;
    RTCPointQueryContext context;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(
        in, &query, &context,
        [](RTCPointQueryFunctionArguments* args) {
          Found& f = *(Found*)args->userPtr;
          f.calls++;
          const RTCGrid& grid = f.diced->grids[args->primID];
          bool changed = false;
          for (unsigned y = 0; y < grid.height; y++)
            for (unsigned x = 0; x < grid.width; x++) {
              const Vec& p = f.diced->vertex(grid, x, y);
              const float d = std::hypot(p[0] - f.at[0], p[1] - f.at[1], p[2] - f.at[2]);
              if (d < args->query->radius) {
                args->query->radius = d;
                f.primID = args->primID;
                changed = true;
              }
            }
          return changed;
        },
        &found);
    return std::make_pair(found.primID == RTC_INVALID_GEOMETRY_ID ? -1.0f : query.radius, found.calls);
  };
  size_t calls = 0, found = 0;
  for (unsigned i = 0; i < 300; i++) {
    const Vec at = {float(random.uniform(-1.2, 1.2)), float(random.uniform(-1.2, 1.2)),
                    float(random.uniform(-0.5, 0.5))};
    const float radius = random.chance(0.3) ? INFINITY : float(random.uniform(0, 0.6));
    const auto expected = nearest(embree, at, radius), actual = nearest(scene, at, radius);
    ASSERT_EQ(expected.first, actual.first);
    calls += actual.second;
    found += actual.first >= 0;
  }
  EXPECT_GT(found, 150u);
  EXPECT_LT(calls, 300u * 36 / 2) << "most grids are too far away";
}

}} // namespace programs::test
