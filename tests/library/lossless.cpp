// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* cbvh_max_error=0: the vertices of grids, quads and triangles are stored exactly, at any position. Rays hit the same
 * triangles as in Embree's kernels, and t, u and v differ only by rounding; the same holds for files. vert_surfaces.cpp
 * tests the vertices of cages, moving_meshes.cpp filters, masks and point queries of moving meshes. */

#include "support/diced.h"
#include "support/diced_mesh.h"
#include "support/hit_error.h"
#include "support/random.h"
#include "support/random_rounds.h"
#include "support/same_hits.h"
#include "support/saved.h"
#include "support/surface_access.h"

#include <array>
#include <cfloat>
#include <cmath>
#include <set>
#include <string>

namespace programs::test { namespace {

const std::string lossless = "cbvh_max_error=0";

class Lossless : public testing::TestWithParam<const char*> {};

INSTANTIATE_TEST_SUITE_P(Isas, Lossless, testing::Values(TEST_ISAS), nameOfIsa);

template<typename Embree, typename Ours, typename Rays>
void expectEmbreesHits(const Embree& embree, const Ours& scene, const Rays& rays) {
  const RTCCompressionStatistics stats = statisticsOf(scene);
  ASSERT_GT(stats.numQuads, 0u);
  ASSERT_EQ(statisticsOf(embree).numQuads, 0u);
  ASSERT_EQ(stats.maxVertexDeviation, 0);
  ASSERT_EQ(stats.maxVertexSpacing, 0);
  ASSERT_EQ(stats.numRawBlocks, 0u);
  expectSameQueries(embree, scene, rays, 2e-3);
}

TEST_P(Lossless, HitsMatchEmbree) {
  Device device(GetParam() + ("," + lossless));
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(1501);
  const struct {
    const char* name;
    Diced diced;
  } shapes[] = {{"a grid of 64 quads", dicedSheet(1, 64)},
                {"grids of 8 quads", dicedSheet(5, 8)},
                {"grids of 33 quads", dicedSheet(2, 33)},
                {"a ball", dicedBall(2, 16)}};
  for (const auto& shape : shapes) {
    SCOPED_TRACE(shape.name);
    ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(GridScene(device, shape.diced, RTC_COMPRESSION_NONE),
                                              GridScene(device, shape.diced), raysAt(random, shape.diced, 403)));
    const DicedMesh quads = meshOf(shape.diced, QuadOrder::Rows, random), triangles = trianglesOf(quads, 1, 2);
    for (const DicedMesh& mesh : {quads, triangles})
      ASSERT_NO_FATAL_FAILURE(expectEmbreesHits(MeshScene(device, mesh, RTC_COMPRESSION_NONE), MeshScene(device, mesh),
                                                raysAt(random, mesh, 403)));
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

Vec withoutSign(const Vec& p) { return {p[0] + 0.0f, p[1] + 0.0f, p[2] + 0.0f}; } // -0 becomes 0

// All finite vertices that the geometry reports.
std::set<Vec> storedVertices(RTCGeometry geometry) {
  std::set<Vec> vertices;
  forEachStoredPart(
      geometry, 0,
      [](void* out, const CbvhPart* part) {
        for (unsigned i = 0; i < part->width * part->height; i++) {
          const float* p = part->vertices + 3 * i;
          if (std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]))
            ((std::set<Vec>*)out)->insert(withoutSign({p[0], p[1], p[2]}));
        }
        return true;
      },
      &vertices);
  return vertices;
}

Vec randomPlace(const Vec& p, const double scale[3], const double away[3]) {
  Vec q;
  for (int k = 0; k < 3; k++) q[k] = float(scale[k] * p[k] + away[k]);
  return q;
}

// Sizes from 1e-30 to 1e12, some different on each axis, around the origin or far from it, some with a stray vertex.
TEST(LosslessVertices, MatchApplicationAtAnyPosition) {
  Device device(lossless);
  Random random(1502);
  for (int round = 0; round < 60; round++) {
    SCOPED_TRACE(testing::Message() << "round " << round);
    double scale[3], away[3];
    const double common = random.magnitude(1e-30, 1e12);
    for (int k = 0; k < 3; k++) {
      scale[k] = round % 3 ? common : random.magnitude(1e-30, 1e12);
      away[k] = round % 2 ? 0 : scale[k] * random.magnitude(1, 1e5) * (random.chance(0.5) ? 1 : -1);
    }
    Diced diced = round % 4 ? dicedSheet(2, 20) : dicedBall(1, 20);
    for (Vec& p : diced.vertices) p = randomPlace(p, scale, away);
    if (round % 5 == 0)
      diced.vertices[random.below(unsigned(diced.vertices.size()))][round % 3] = float(random.magnitude(1e6, 1e17));
    std::set<Vec> expected;
    for (const Vec& p : diced.vertices) expected.insert(withoutSign(p));
    const DicedMesh quads = meshOf(diced, QuadOrder::Rows, random);
    const std::pair<const char*, RTCGeometry> geometries[] = {
        {"grids", newGrids(device, diced, RTC_COMPRESSION_CVERT)},
        {"quads", newMesh(device, quads, RTC_COMPRESSION_CVERT)},
        {"triangles", newMesh(device, trianglesOf(quads), RTC_COMPRESSION_CVERT)}};
    for (const auto& g : geometries) {
      SCOPED_TRACE(g.first);
      Scene scene(device);
      rtcRetainGeometry(g.second);
      attach(scene, g.second);
      rtcCommitScene(scene);
      EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      EXPECT_GT(statisticsOf(scene).numQuads, 0u);
      EXPECT_EQ(statisticsOf(scene).maxVertexDeviation, 0);
      EXPECT_TRUE(storedVertices(g.second) == expected);
      rtcReleaseGeometry(g.second);
    }
  }
}

// For vertices that do not need all bits of a float.
TEST(LosslessVertices, TakeFewerBytesThanEmbree) {
  Device device(lossless);
  Random random(1503);
  Diced terrain;
  terrain.add(257, 257, [&](unsigned x, unsigned y) {
    return Vec{float(x), float(y),
               float(100 + 3 * std::sin(0.05 * x) + 2 * std::cos(0.07 * y) + 0.01 * random.normal())};
  });
  const RTCCompressionStatistics stats = statisticsOf(GridScene(device, terrain));
  EXPECT_EQ(stats.numRawBlocks, 0u);
  EXPECT_LT(double(stats.headerBytes + stats.nodeBytes + stats.leafBytes) / double(stats.numQuads), 2.9);
  const RTCCompressionStatistics ball = statisticsOf(GridScene(device, dicedBall(4, 64)));
  EXPECT_LT(ball.numRawBlocks, ball.numBlocks / 20);
  EXPECT_LT(double(ball.headerBytes + ball.nodeBytes + ball.leafBytes) / double(ball.numQuads), 8);
}

// --- t, u and v, and files -------------------------------------------------------------------------

struct Source {
  std::string name;
  bool isCage, isGrids, moves;
  std::function<RTCGeometry(RTCDevice, RTCCompression)> make;
};

// Rotates and bends around a point that may be far from the origin.
Vec bentAround(const Vec& p, const Vec& middle, unsigned step) {
  const double a = 0.3 * step, c = std::cos(a), s = std::sin(a);
  const double x = double(p[0]) - middle[0], y = double(p[1]) - middle[1], z = double(p[2]) - middle[2];
  return {float(middle[0] + c * x - s * y), float(middle[1] + s * x + c * y),
          float(middle[2] + z + 0.01 * step * x * x)};
}

// Cells of 2 m at coordinates where floats are half a meter apart.
Diced nationalGrid() {
  Diced diced;
  for (unsigned tile : {0u, 1u})
    diced.add(65, 65, [&](unsigned x, unsigned y) {
      const double i = x + 64 * tile;
      const double height = 300 + 20 * std::sin(0.11 * i) * std::cos(0.07 * y) + 3 * std::sin(0.9 * i + y);
      return Vec{float(4.5e6 + 2 * i), float(5.4e6 + 2 * y), float(height)};
    });
  return diced;
}

std::vector<Source> allSources(Random& random) {
  static Displacement displacement;
  std::vector<Source> sources;
  for (unsigned timeSteps : {1u, 3u}) {
    const bool moves = timeSteps > 1;
    const std::string suffix = moves ? ", moving" : "";
    const std::pair<const char*, Cage> cages[] = {{"a cage of quads", cubeCage()},
                                                  {"a cage of pentagons", prismCage(5)}};
    for (const auto& cage : cages)
      sources.push_back({cage.first + suffix, true, false, moves, [=](RTCDevice device, RTCCompression compression) {
                           SurfaceSettings settings;
                           settings.displacement = &displacement;
                           settings.rate = 32;
                           settings.timeSteps = timeSteps;
                           settings.motion = [](const Vec& p, unsigned step) { return bentAround(p, {0, 0, 0}, step); };
                           settings.compression = compression;
                           return newSurface(device, cage.second, settings);
                         }});
    const struct {
      const char* name;
      Diced diced;
      Vec middle;
    } shapes[] = {{"a sheet", dicedSheet(2, 33), {0, 0, 0}},
                  {"a ball", dicedBall(2, 16), {0, 0, 0}},
                  {"a terrain", nationalGrid(), {4.5e6f, 5.4e6f, 300}}};
    for (const auto& shape : shapes) {
      Diced grids = shape.diced;
      grids.motion = [middle = shape.middle](const Vec& p, unsigned step) { return bentAround(p, middle, step); };
      DicedMesh quads = meshOf(grids, QuadOrder::Rows, random);
      quads.motion = grids.motion;
      const DicedMesh triangles = trianglesOf(quads, 1, 2);
      const std::string name = shape.name + suffix;
      sources.push_back({name + ", grids", false, true, moves, [=](RTCDevice device, RTCCompression compression) {
                           return newGrids(device, grids, compression, 0, timeSteps);
                         }});
      for (const DicedMesh& mesh : {quads, triangles})
        sources.push_back({name + (mesh.isTriangleForm() ? ", triangles" : ", quads"), false, false, moves,
                           [=](RTCDevice device, RTCCompression compression) {
                             return newMesh(device, mesh, compression, 0, timeSteps);
                           }});
    }
  }
  return sources;
}

class SourceScene : public Scene {
public:
  SourceScene(RTCDevice device, const Source& source, RTCCompression compression)
    : SourceScene(device, source.make(device, compression)) {}
  SourceScene(RTCDevice device, RTCGeometry geometry) : Scene(device), geometry(geometry) {
    attach(*this, geometry);
    rtcCommitScene(*this);
  }
  const RTCGeometry geometry;
};

// Rays at random points of the stored triangles, from a distance of 2 to 2000 edges.
std::vector<RTCRayHit> raysAtStored(Random& random, RTCGeometry geometry, float time, unsigned count) {
  typedef std::array<Vec, 3> Triangle;
  std::vector<Triangle> triangles;
  forEachStoredPart(
      geometry, time,
      [](void* out, const CbvhPart* part) {
        const auto at = [&](unsigned x, unsigned y) {
          const float* p = part->vertices + 3 * (y * part->width + x);
          return Vec{p[0], p[1], p[2]};
        };
        for (unsigned y = 0; y + 1 < part->height; y++)
          for (unsigned x = 0; x + 1 < part->width; x++) {
            ((std::vector<Triangle>*)out)->push_back({at(x, y), at(x + 1, y), at(x, y + 1)});
            ((std::vector<Triangle>*)out)->push_back({at(x, y + 1), at(x + 1, y), at(x + 1, y + 1)});
          }
        return true;
      },
      &triangles);
  std::vector<RTCRayHit> rays;
  while (rays.size() < count && !triangles.empty()) {
    const Triangle& triangle = triangles[random.below(unsigned(triangles.size()))];
    double a = random.uniform(), b = random.uniform(), length = 0, edge = 0, d[3];
    if (a + b > 1) {
      a = 1 - a;
      b = 1 - b;
    }
    for (double& x : d) {
      x = random.normal();
      length += x * x;
    }
    for (int k = 0; k < 3; k++) edge = std::max(edge, std::fabs(double(triangle[1][k]) - triangle[0][k]));
    const double distance = edge * random.magnitude(2, 2000) / std::sqrt(length);
    Vec origin, direction;
    for (int k = 0; k < 3; k++) {
      const double target = triangle[0][k] + a * (double(triangle[1][k]) - triangle[0][k]) +
                            b * (double(triangle[2][k]) - triangle[0][k]);
      origin[k] = float(target + distance * d[k]);
      direction[k] = float(target - origin[k]);
    }
    rays.push_back(makeRay(origin, direction));
    rays.back().ray.time = time;
  }
  return rays;
}

// t in its ulps, u and v in ulps of 1.
struct Differences {
  double t = 0, uv = 0;

  template<typename A, typename B>
  void add(const A& a, const B& b, double ulpOfT) {
    t = std::max(t, std::fabs(double(a.t) - double(b.t)) / ulpOfT);
    for (double d : {double(a.u) - double(b.u), double(a.v) - double(b.v)})
      uv = std::max(uv, std::fabs(d) / FLT_EPSILON);
  }

  std::string text() const { return std::to_string(t) + ", " + std::to_string(uv); }
};

struct HitValues {
  float t, u, v;
  explicit HitValues(const RTCRayHit& r) : t(r.ray.tfar), u(r.hit.u), v(r.hit.v) {}
};

bool findTriangle(RTCGeometry geometry, const RTCRayHit& r, CbvhTriangle& triangle) {
  const RTCHit& hit = r.hit;
  return isHit(r) && findStoredTriangle(geometry, r.ray.time, hit.primID, hit.u, hit.v, &hit.Ng_x, &triangle);
}

template<typename Found>
void expectWithin(const char* whose, const Found& found, const ExactTriangleHit& exact, const HitError& bound) {
  ASSERT_LE(std::fabs(double(found.t) - exact.t), bound.t) << whose << " t";
  ASSERT_LE(std::fabs(double(found.u) - exact.u), bound.u) << whose << " u";
  ASSERT_LE(std::fabs(double(found.v) - exact.v), bound.v) << whose << " v";
}

/* Compares the hits of both kernels on a triangle with the exact hit, except for rays nearly in its plane: our kernel
 * clamps t, and first-order bounds do not hold. More rays: CBVH_RANDOM_GEOMETRIES=2000. */
TEST_P(Lossless, HitsDifferFromEmbreeOnlyByRounding) {
  Device device(GetParam() + ("," + lossless));
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(1504);
  constexpr double leastCosine = 1e-3;
  const unsigned raysOfSource = unsigned(randomRounds(320));
  for (const Source& source : allSources(random)) {
    SCOPED_TRACE(source.name);
    const SourceScene embree(device, source, RTC_COMPRESSION_NONE), ours(device, source, RTC_COMPRESSION_CVERT);
    const RTCCompressionStatistics stats = statisticsOf(ours);
    ASSERT_GT(stats.numQuads, 0u);
    ASSERT_EQ(stats.maxVertexDeviation, 0);
    ASSERT_EQ(statisticsOf(embree).numQuads, 0u);
    std::vector<RTCRayHit> rays;
    const unsigned times = source.moves ? 4 : 1;
    for (unsigned i = 0; i < times; i++) {
      const float time = source.moves ? float(random.uniform()) : 0;
      for (const RTCRayHit& ray : raysAtStored(random, ours.geometry, time, raysOfSource / times)) rays.push_back(ray);
    }
    ASSERT_EQ(rays.size(), raysOfSource);
    Differences ofOurs, ofEmbree, between;
    size_t compared = 0, others = 0;
    std::set<std::array<float, 8>> known; // pairs of hits that another form of query also had
    for (QueryForm form : allQueryForms) {
      SCOPED_TRACE(nameOf(form));
      const std::vector<RTCRayHit> expected = closestHits(embree, rays, form), found = closestHits(ours, rays, form);
      for (size_t i = 0; i < rays.size(); i++) {
        const HitValues e(expected[i]), f(found[i]);
        if (!known.insert({float(i), e.t, e.u, e.v, f.t, f.u, f.v, float(isHit(expected[i]))}).second) continue;
        SCOPED_TRACE(testing::Message() << "ray " << i);
        CbvhTriangle triangle, theirs;
        if (!findTriangle(ours.geometry, found[i], triangle) || !findTriangle(ours.geometry, expected[i], theirs) ||
            expected[i].hit.primID != found[i].hit.primID || std::memcmp(&triangle, &theirs, sizeof(triangle)) != 0) {
          others++;
          continue;
        }
        const ExactTriangleHit exact(rays[i].ray, triangle);
        if (!exact.isMet() || exact.cosine < leastCosine) continue;
        compared++;
        /* GRID's faces evaluate a border with differences of some ulps, and its vertices have 13 bits of u and v.
         * Moving vertices are the same floats in both libraries, except that Embree interpolates grids by another
         * formula: at most three roundings in either. */
        double vertexError[3];
        for (int k = 0; k < 3; k++) {
          float largest = 0;
          for (const auto& vertex : triangle.vertices) largest = std::max(largest, std::fabs(vertex[k]));
          vertexError[k] = source.isCage                    ? stats.maxBorderMismatch
                           : source.isGrids && source.moves ? 6 * unitRoundoff * largest
                                                            : 0;
        }
        const HitError bound = exact.embreesBound(vertexError, source.isCage ? 0x1p-13 : 0);
        ASSERT_NO_FATAL_FAILURE(expectWithin("our", f, exact, exact.oursBound()));
        ASSERT_NO_FATAL_FAILURE(expectWithin("Embree's", e, exact, bound));
        const double ulp = ulpOf(float(exact.t));
        ofOurs.add(f, exact, ulp);
        ofEmbree.add(e, exact, ulp);
        between.add(e, f, ulp);
      }
    }
    EXPECT_GT(compared, raysOfSource / 2);
    EXPECT_GT(compared, others);
    RecordProperty(source.name + ": ours from exact, ulps of t, of u and v", ofOurs.text());
    RecordProperty(source.name + ": Embree's from exact", ofEmbree.text());
    RecordProperty(source.name + ": ours from Embree's", between.text());
    RecordProperty(source.name + ": hits compared, others", std::to_string(compared) + ", " + std::to_string(others));
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

/* Hits equal the hits before saving bit by bit, and match Embree's within a tolerance, because Embree interpolates
 * grids differently. */
TEST_P(Lossless, FilesHaveTheSameHits) {
  Device device(GetParam() + ("," + lossless));
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(1505);
  for (const Source& source : allSources(random)) {
    SCOPED_TRACE(source.name);
    Folder folder;
    const SourceScene embree(device, source, RTC_COMPRESSION_NONE), saved(device, source, RTC_COMPRESSION_CVERT);
    ASSERT_TRUE(saveGeometryFile(saved.geometry, (folder / "lossless").c_str())) << device.message;
    const RTCGeometry geometry = loadGeometryFile(device, (folder / "lossless").c_str());
    ASSERT_NE(geometry, nullptr) << device.message;
    const SourceScene loaded(device, geometry);
    ASSERT_EQ(statisticsOf(loaded).maxVertexDeviation, 0);
    ASSERT_EQ(statisticsOf(loaded).numQuads, statisticsOf(saved).numQuads);
    ASSERT_TRUE(storedVertices(loaded.geometry) == storedVertices(saved.geometry));
    const float time = !source.moves ? 0 : source.isGrids ? 0.5f : 0.3f;
    const std::vector<RTCRayHit> rays = raysAtStored(random, saved.geometry, time, 500);
    for (QueryForm form : allQueryForms) {
      SCOPED_TRACE(nameOf(form));
      const std::vector<RTCRayHit> expected = closestHits(saved, rays, form), found = closestHits(loaded, rays, form),
                                   any = anyHits(loaded, rays, form), embrees = closestHits(embree, rays, form);
      size_t others = 0;
      for (size_t i = 0; i < rays.size(); i++) {
        SCOPED_TRACE(testing::Message() << "ray " << i);
        const RTCRayHit &e = expected[i], &f = found[i];
        ASSERT_EQ(std::memcmp(&e.ray.tfar, &f.ray.tfar, sizeof(float)), 0);
        ASSERT_EQ(isHit(e), isHit(f));
        ASSERT_EQ(any[i].ray.tfar < 0, isHit(f));
        if (isHit(e)) { ASSERT_EQ(std::memcmp(&e.hit, &f.hit, offsetof(RTCHit, instID) + sizeof(e.hit.instID)), 0); }
        // a ray that passes close to an edge may hit its other side
        others += isHit(embrees[i]) != isHit(f) || embrees[i].hit.primID != f.hit.primID ||
                  std::fabs(embrees[i].ray.tfar - f.ray.tfar) > 1e-5 * f.ray.tfar * std::max(1.0, 0.1 / cosine(f));
      }
      ASSERT_LE(others, rays.size() / 100);
    }
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

}} // namespace programs::test
