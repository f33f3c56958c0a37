// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Surfaces of cVERT are closed, within the promised distance of GRID's, and traced as the scalar decoder decodes
 * them. */

#include "support/edge_rates.h"
#include "support/vert_triangles.h"
#include "support/vertex_recorder.h"

#include <cmath>
#include <map>
#include <optional>
#include <tuple>

namespace programs::test { namespace {

constexpr double ulp = 0x1p-23;

// Along the face's own normal, which differs from the neighbors' at extraordinary vertices.
struct AlongNormals : public VertexRecorder {
  float amplitude = 0.1f, jump = 0; // jump: added to the height primID % 3 times
  std::vector<Vec> recorded;

  static void displaceAlongNormals(const RTCDisplacementFunctionNArguments* args) {
    const AlongNormals& d = *static_cast<AlongNormals*>((Displacement*)args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; i++) {
      const float h = d.amplitude * std::sin(9 * args->P_x[i] + 5 * args->P_y[i]) * std::cos(7 * args->P_z[i]) +
                      d.jump * float(args->primID % 3);
      args->P_x[i] += h * args->Ng_x[i];
      args->P_y[i] += h * args->Ng_y[i];
      args->P_z[i] += h * args->Ng_z[i];
    }
  }

  void record(const RTCDisplacementFunctionNArguments&) override {}
};

SurfaceSettings vert(float rate = 16) {
  SurfaceSettings settings;
  settings.compression = RTC_COMPRESSION_CVERT;
  settings.rate = rate;
  return settings;
}

void commitAlongNormals(RTCDevice device, RTCScene scene, const Cage& cage, const SurfaceSettings& settings,
                        AlongNormals& displacement) {
  RTCGeometry geometry = newSurface(device, cage, settings);
  rtcSetGeometryUserData(geometry, static_cast<Displacement*>(&displacement));
  rtcSetGeometryDisplacementFunction(geometry, AlongNormals::displaceAlongNormals);
  rtcCommitGeometry(geometry);
  attach(scene, geometry);
  rtcCommitScene(scene);
}

// Every edge of every triangle must occur in the opposite direction with the same floats.
TEST(VertSurfaces, ClosedSurfacesShareEveryEdge) {
  Device device;
  for (const auto& cage : closedCages)
    for (float rate : {1.0f, 2.0f, 3.0f, 5.0f, 8.0f, 13.0f, 17.0f, 64.0f}) {
      SCOPED_TRACE(testing::Message() << cage.name << ", rate " << rate);
      Displacement displacement;
      SurfaceSettings settings = vert(rate);
      settings.displacement = &displacement;
      const SurfaceScene scene(device, cage.cage, settings);
      const std::vector<VertTriangle> triangles = vertTriangles(scene);
      EXPECT_EQ(2 * statisticsOf(scene).numQuads, triangles.size());
      EXPECT_EQ(countOpenEdges(triangles), 0u) << "of " << 3 * triangles.size() / 2;
      EXPECT_EQ(statisticsOf(scene).numRawBlocks, 0u);
    }
}

TEST(VertSurfaces, NeighborsWithDifferentRatesShareEveryEdge) {
  Device device;
  for (const auto& cage : closedCages)
    for (const auto& set : rateSets) {
      SCOPED_TRACE(testing::Message() << cage.name << ", rates " << set.name);
      Random random(81);
      Displacement displacement;
      SurfaceSettings settings = vert();
      settings.displacement = &displacement;
      settings.edgeRates = drawRates(cage.cage, random, set.draw);
      const SurfaceScene scene(device, cage.cage, settings);
      EXPECT_EQ(countOpenEdges(vertTriangles(scene)), 0u);
    }
}

// GRID has gaps if both sides of an edge have different rates.
TEST(VertSurfaces, SidesWithDifferentRatesShareEdge) {
  Device device;
  for (const auto& cage : closedCages) {
    SCOPED_TRACE(cage.name);
    Random random(82);
    Displacement displacement;
    SurfaceSettings settings = vert();
    settings.displacement = &displacement;
    for (size_t i = 0; i < cage.cage.indices.size(); i++) settings.edgeRates.push_back(float(1 + random.below(40)));
    const SurfaceScene scene(device, cage.cage, settings);
    EXPECT_EQ(countOpenEdges(vertTriangles(scene)), 0u);
  }
}

// Three walls share the vertices of one edge.
TEST(VertSurfaces, FacesOnNonManifoldEdgeShareIt) {
  Device device;
  Cage cage;
  cage.positions = {{0, 0, 0},     {0, 0, 1},     {1, 0, 0},    {1, 0, 1},
                    {-1, 0.3f, 0}, {-1, 0.3f, 1}, {0.1f, 1, 0}, {0.1f, 1, 1}};
  cage.addFace({0, 2, 3, 1});
  cage.addFace({0, 4, 5, 1});
  cage.addFace({0, 6, 7, 1});
  for (const std::vector<float>& rates :
       {std::vector<float>(12, 16.0f), std::vector<float>{16, 16, 16, 4, 8, 8, 8, 8, 16, 16, 16, 16}}) {
    AlongNormals displacement;
    SurfaceSettings settings = vert();
    settings.edgeRates = rates;
    Scene scene(device);
    commitAlongNormals(device, scene, cage, settings, displacement);
    // the shared polyline has the lowest rate: each of its edges occurs three times
    std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, int> uses;
    for (const VertTriangle& t : vertTriangles(scene))
      for (int i = 0; t.hasArea() && i < 3; i++) uses[std::minmax(t.vertices[i], t.vertices[(i + 1) % 3])]++;
    size_t threefold = 0;
    for (const auto& edge : uses) threefold += edge.second == 3;
    EXPECT_EQ(threefold, size_t(*std::min_element(rates.begin(), rates.end())));
  }
}

// GRID has gaps here, of hundreds of ulps or of a part of the object.
TEST(VertSurfaces, ExtraordinaryVerticesAndSeamsAreClosed) {
  Device device;
  for (const auto& cage : closedCages)
    for (float jump : {0.0f, 0.1f}) {
      SCOPED_TRACE(testing::Message() << cage.name << ", jump " << jump);
      AlongNormals displacement;
      displacement.jump = jump;
      Scene scene(device);
      commitAlongNormals(device, scene, cage.cage, vert(16), displacement);
      EXPECT_EQ(countOpenEdges(vertTriangles(scene)), 0u);
      const RTCCompressionStatistics stats = statisticsOf(scene);
      EXPECT_GT(stats.maxBorderMismatch, jump);
      EXPECT_LE(stats.maxVertexDeviation, 0.8661f * stats.maxVertexSpacing);
    }
}

// --- promised distance ------------------------------------------------------------------

// Vertices by face and parameters in units of 2^-16.
typedef std::tuple<unsigned, long, long> VertexKey;
VertexKey keyOf(unsigned primID, double u, double v) {
  return {primID, std::lround(u * 65536), std::lround(v * 65536)};
}

struct EveryVertex : public VertexRecorder {
  std::map<VertexKey, Vec> vertices;

  void record(const RTCDisplacementFunctionNArguments& args) override {
    for (unsigned i = 0; i < args.N; i++)
      vertices[keyOf(args.primID, args.u[i], args.v[i])] = {args.P_x[i], args.P_y[i], args.P_z[i]};
  }
};

double distance(const std::array<float, 3>& a, const Vec& b) {
  double d2 = 0;
  for (int k = 0; k < 3; k++) d2 += std::pow(double(a[k]) - b[k], 2);
  return std::sqrt(d2);
}

double largestDeviation(RTCScene scene, const EveryVertex& grid) {
  double largest = 0;
  size_t compared = 0;
  for (const VertTriangle& t : vertTriangles(scene))
    for (int c = 0; c < 3; c++) {
      const auto found = grid.vertices.find(keyOf(t.primID, t.u[c], t.v[c]));
      EXPECT_NE(found, grid.vertices.end())
          << "GRID has no vertex at " << t.u[c] << ", " << t.v[c] << " of face " << t.primID;
      if (found == grid.vertices.end()) return INFINITY;
      largest = std::max(largest, distance(t.vertices[c], found->second));
      compared++;
    }
  EXPECT_GT(compared, 0u);
  return largest;
}

// GRID's surface and vertices, and the settings that give cVERT the same vertices.
struct Recorded {
  EveryVertex grid;
  Scene reference;
  SurfaceSettings settings;

  Recorded(RTCDevice device, const Cage& cage) : reference(device) {
    settings.rate = 16;
    settings.compression = RTC_COMPRESSION_NONE;
    grid.build(device, reference, cage, settings);
    settings.displacement = &grid;
    settings.compression = RTC_COMPRESSION_CVERT;
  }
};

TEST(VertSurfaces, NoVertexIsFartherFromGridThanPromised) {
  Device device;
  const double halfDiagonal = std::sqrt(3) / 2;
  for (const auto& cage : closedCages)
    for (float maxError : {0.0f, 0.05f, 0.001f, 3e-5f, 1e-6f}) { // 0: the default
      SCOPED_TRACE(testing::Message() << cage.name << ", bound " << maxError);
      Recorded recorded(device, cage.cage);
      recorded.settings.maxError = maxError;
      const SurfaceScene scene(device, cage.cage, recorded.settings);
      const RTCCompressionStatistics stats = statisticsOf(scene);
      if (maxError > 0) {
        EXPECT_LE(stats.maxVertexSpacing, maxError);
        EXPECT_GT(stats.maxVertexSpacing, 0.5f * maxError);
      }
      EXPECT_GT(stats.maxVertexDeviation, 0);
      EXPECT_LE(stats.maxVertexDeviation, halfDiagonal * stats.maxVertexSpacing);
      // faces evaluate shared vertices with differences of some ulps
      const double largest = largestDeviation(scene, recorded.grid);
      EXPECT_LE(largest, stats.maxVertexDeviation + stats.maxBorderMismatch + 1e-6);
      EXPECT_LE(stats.maxBorderMismatch, 1e-5f);
      EXPECT_LE(largest, halfDiagonal * stats.maxVertexSpacing + 1e-5);
      EXPECT_EQ(stats.numRawBlocks, 0u);
    }
}

TEST(VertSurfaces, LosslessStoresVerticesThatGridEvaluates) {
  Device device("cbvh_max_error=0");
  for (const auto& cage : closedCages) {
    SCOPED_TRACE(cage.name);
    const Recorded recorded(device, cage.cage);
    const SurfaceScene scene(device, cage.cage, recorded.settings);
    const RTCCompressionStatistics stats = statisticsOf(scene);
    EXPECT_EQ(stats.maxVertexDeviation, 0);
    EXPECT_EQ(stats.maxVertexSpacing, 0);
    EXPECT_EQ(stats.numFlippedQuads, 0u);
    EXPECT_LE(largestDeviation(scene, recorded.grid), stats.maxBorderMismatch * 1.0001)
        << "faces evaluate borders with differences of some ulps";
    EXPECT_LE(stats.maxBorderMismatch, 1e-5f);
    EXPECT_EQ(countOpenEdges(vertTriangles(scene)), 0u);
  }
}

// On a border whose edge has a lower rate, each vertex must be the one to which Embree stitches it.
TEST(VertSurfaces, BordersOfLowerRatesHaveStitchedVerticesOfGrid) {
  Device device;
  const Cage cage = cubeCage();
  Random random(86);
  size_t between = 0;
  for (unsigned most : {3u, 8u, 40u}) {
    EveryVertex grid;
    SurfaceSettings settings;
    settings.edgeRates = drawRates(cage, random, [&](Random& r) { return float(1 + r.below(most)); });
    settings.compression = RTC_COMPRESSION_NONE;
    Scene reference(device);
    grid.build(device, reference, cage, settings);
    settings.displacement = &grid;
    settings.compression = RTC_COMPRESSION_CVERT;
    const SurfaceScene scene(device, cage, settings);
    const double bound = 0.8661 * statisticsOf(scene).maxVertexSpacing + 1e-5;
    for (const VertTriangle& t : vertTriangles(scene))
      for (int c = 0; c < 3; c++)
        for (unsigned side = 0; side < 4; side++) {
          const bool alongU = side % 2 == 0;
          if ((alongU ? t.v[c] : t.u[c]) != (side == 1 || side == 2)) continue;
          const double rate = settings.edgeRates[4 * t.primID + side],
                       quads = std::max(rate, double(settings.edgeRates[4 * t.primID + (side + 2) % 4]));
          const double i = std::round(quads * (alongU ? t.u[c] : t.v[c])),
                       k = i == quads ? rate : std::floor((i + 0.5) * rate / quads);
          const auto found =
              grid.vertices.find(keyOf(t.primID, alongU ? k / rate : t.u[c], alongU ? t.v[c] : k / rate));
          ASSERT_NE(found, grid.vertices.end());
          ASSERT_LE(distance(t.vertices[c], found->second), bound)
              << "face " << t.primID << ", side " << side << ", vertex " << i << " of " << quads << " with " << rate;
          between += rate < quads && i != 0 && i != quads;
        }
  }
  EXPECT_GT(between, 100u);
}

// Dot product, not normalized, with the normal of GRID's vertices: negative if the triangle is flipped, 0 if it has no
// area.
double normalCosine(const VertTriangle& t, const EveryVertex& grid) {
  double normals[2][3];
  for (int side = 0; side < 2; side++) {
    double edge[2][3];
    for (int c = 0; c < 2; c++)
      for (int k = 0; k < 3; k++) {
        const auto at = [&](int i) {
          return side ? double(t.vertices[i][k]) : double(grid.vertices.at(keyOf(t.primID, t.u[i], t.v[i]))[k]);
        };
        edge[c][k] = at(c + 1) - at(0);
      }
    for (int k = 0; k < 3; k++)
      normals[side][k] = edge[0][(k + 1) % 3] * edge[1][(k + 2) % 3] - edge[0][(k + 2) % 3] * edge[1][(k + 1) % 3];
  }
  return normals[0][0] * normals[1][0] + normals[0][1] * normals[1][1] + normals[0][2] * normals[1][2];
}

TEST(VertSurfaces, FlippedQuadsAreCounted) {
  Device device;
  size_t flipped = 0;
  for (const auto& cage : closedCages)
    for (float rate : {2.0f, 8.0f, 16.0f}) {
      SCOPED_TRACE(testing::Message() << cage.name << ", rate " << rate);
      EveryVertex grid;
      SurfaceSettings settings;
      settings.rate = rate;
      settings.compression = RTC_COMPRESSION_NONE;
      Scene reference(device);
      grid.build(device, reference, cage.cage, settings);
      settings.displacement = &grid;
      settings.compression = RTC_COMPRESSION_CVERT;
      settings.maxError = 1.5f / rate; // larger than a quad
      const SurfaceScene scene(device, cage.cage, settings);
      const std::vector<VertTriangle> triangles = vertTriangles(scene);
      size_t certain = 0, possible = 0; // the vertices of a face's border match GRID's except for some ulps
      for (size_t i = 0; i < triangles.size(); i += 2) { // two per quad
        const double likenesses[2] = {normalCosine(triangles[i], grid), normalCosine(triangles[i + 1], grid)};
        const auto isOf = [&](double bound) {
          return std::any_of(likenesses, likenesses + 2, [&](double l) { return l != 0 && l < bound; });
        };
        certain += isOf(-1e-9);
        possible += isOf(1e-9);
      }
      EXPECT_GE(statisticsOf(scene).numFlippedQuads, certain);
      EXPECT_LE(statisticsOf(scene).numFlippedQuads, possible);
      flipped += certain;
    }
  EXPECT_GT(flipped, 100u);
}

// The dot product of two normals has the fourth power of an edge's length.
TEST(VertSurfaces, FlippedQuadsAreCountedAtAnyScale) {
  Device device;
  size_t total = 0;
  for (const auto& shape : closedCages)
    for (float rate : {2.0f, 8.0f, 16.0f}) {
      size_t flipped = 0;
      for (float scale : {1.0f, 0x1p-40f, 0x1p40f}) {
        SCOPED_TRACE(testing::Message() << shape.name << ", rate " << rate << ", scale " << scale);
        Cage cage = shape.cage;
        for (Vec& p : cage.positions)
          for (float& x : p) x *= scale;
        SurfaceSettings settings;
        settings.rate = rate;
        settings.compression = RTC_COMPRESSION_CVERT;
        settings.maxError = scale * 1.5f / rate; // larger than a quad
        const SurfaceScene scene(device, cage, settings);
        ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
        const size_t n = statisticsOf(scene).numFlippedQuads;
        if (scale == 1) flipped = n;
        else EXPECT_EQ(n, flipped);
      }
      total += flipped;
    }
  EXPECT_GT(total, 0u);
}

TEST(VertSurfaces, SpacingIsAtMostTheBoundInPixelsOfACamera) {
  Device device;
  Displacement displacement;
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.rate = 16;
  settings.compression = RTC_COMPRESSION_CVERT;
  RTCGeometry geometry = newSurface(device, sheetCage(8), settings);
  RTCCompressionArguments args;
  rtcInitCompressionArguments(&args);
  args.compression = RTC_COMPRESSION_CVERT;
  args.maxPixelError = 0.5f;
  args.pixelSize = 0.002f;
  args.cameraPosition[0] = -2;
  args.cameraPosition[2] = 0.3f;
  rtcSetGeometryCompression(geometry, &args);
  rtcCommitGeometry(geometry);
  Scene scene(device);
  attach(scene, geometry);
  rtcCommitScene(scene);
  ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  float finest = INFINITY, coarsest = 0;
  for (const cvert::VertHeader* block : sceneVertBlocks(scene)) {
    const cvert::DecodedBlock decoded(block);
    double nearest = INFINITY;
    for (uint32_t i = 0; i < (decoded.quadsX + 1) * (decoded.quadsY + 1); i++)
      nearest = std::min(nearest,
                         std::hypot(decoded.vertices[i][0] + 2, decoded.vertices[i][1], decoded.vertices[i][2] - 0.3));
    const cvert::VertSpacing spacings = cvert::vertSpacing(block->word, block->corners);
    const float spacing = *std::min_element(spacings.at, spacings.at + 3);
    EXPECT_LE(spacing, 0.5 * 0.002 * nearest);
    finest = std::min(finest, spacing);
    coarsest = std::max(coarsest, spacing);
  }
  EXPECT_LT(finest, coarsest);
}

// --- rays ----------------------------------------------------------------------------

// The hit must be on the nearest decoded triangle. Rays within rounding of an edge are skipped.
void expectTriangleHits(RTCScene scene, const std::vector<RTCRayHit>& rays) {
  const std::vector<VertTriangle> triangles = vertTriangles(scene);
  constexpr double rounding = 1e-4; // of weights
  size_t hits = 0, nearEdges = 0;
  for (const RTCRayHit& ray : rays) {
    ExactHit nearest, candidate;
    bool nearEdge = false;
    for (const VertTriangle& t : triangles)
      if (meet(ray.ray, t, candidate) && candidate.t >= ray.ray.tnear && candidate.t <= ray.ray.tfar &&
          inside(candidate) >= -rounding) {
        if (candidate.t < nearest.t + 1e-5) nearEdge |= inside(candidate) < rounding;
        if (inside(candidate) >= 0 && candidate.t < nearest.t) nearest = candidate;
      }
    const RTCRayHit found = intersect(scene, ray);
    ASSERT_EQ(occluded(scene, ray), isHit(found));
    if (nearEdge) {
      nearEdges++;
      continue;
    }
    ASSERT_EQ(isHit(found), nearest.triangle != nullptr)
        << "t " << nearest.t << " found " << found.ray.tfar << " prim " << found.hit.primID << " " << found.hit.u << " "
        << found.hit.v;
    if (!isHit(found)) continue;
    hits++;
    const VertTriangle& t = *nearest.triangle;
    ASSERT_EQ(found.hit.primID, t.primID);
    ASSERT_NEAR(found.ray.tfar, nearest.t, 64 * ulp * std::max(1.0, nearest.t));
    double u = 0, v = 0, n[3], e[2][3];
    for (int c = 0; c < 3; c++) {
      u += nearest.weight[c] * t.u[c];
      v += nearest.weight[c] * t.v[c];
    }
    ASSERT_NEAR(found.hit.u, u, 1e-4);
    ASSERT_NEAR(found.hit.v, v, 1e-4);
    for (int k = 0; k < 3; k++) {
      e[0][k] = double(t.vertices[1][k]) - t.vertices[0][k];
      e[1][k] = double(t.vertices[2][k]) - t.vertices[0][k];
    }
    for (int k = 0; k < 3; k++) n[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    const float ng[3] = {found.hit.Ng_x, found.hit.Ng_y, found.hit.Ng_z};
    for (int k = 0; k < 3; k++) ASSERT_NEAR(ng[k], n[k], 1e-5 * length);
  }
  EXPECT_GT(hits, rays.size() / 4);
  EXPECT_LT(nearEdges, rays.size() / 10);
}

class VertRays : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Isas, VertRays, testing::Values(TEST_ISAS), [](const auto& info) {
  std::string name;
  for (char c : info.param.substr(4))
    if (c != '.') name += c;
  return name;
});

TEST_P(VertRays, HitsMatchDecodedTriangles) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Random random(83);
  for (const auto& cage : closedCages)
    for (float rate : {1.0f, 2.0f, 3.0f, 6.0f, 16.0f, 21.0f}) {
      SCOPED_TRACE(testing::Message() << cage.name << ", rate " << rate);
      Displacement displacement;
      displacement.amplitude = 0.1f;
      SurfaceSettings settings = vert(rate);
      settings.displacement = &displacement;
      const SurfaceScene scene(device, cage.cage, settings);
      expectTriangleHits(scene, raysAt(random, 200));
      if (HasFatalFailure()) return;
    }
}

// z = |x - 4|/4
void foldAt4(const RTCDisplacementFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; i++) {
    args->P_x[i] = std::nearbyint(args->P_x[i]);
    args->P_y[i] = std::nearbyint(args->P_y[i]);
    args->P_z[i] = 0.25f * std::fabs(args->P_x[i] - 4);
  }
}

// Triangles of two groups share the edge of a fold: the first group's wins, in any order of traversal.
TEST_P(VertRays, FirstTriangleWinsOnAFold) {
  Device device(GetParam());
  if (!device) GTEST_SKIP() << "this machine does not support " << GetParam();
  Scene scene(device);
  RTCGeometry sheet = newSurface(device, quadCage(16), vert(16));
  rtcSetGeometryDisplacementFunction(sheet, foldAt4);
  rtcCommitGeometry(sheet);
  attach(scene, sheet);
  rtcCommitScene(scene);
  ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
  for (float slope : {0.0f, 0.25f, -0.25f})
    for (float y = 0.125f; y < 16; y += 0.125f) { // also at vertices, where a group has several triangles
      RTCRayHit ray = makeRay({4 + 8 * slope, y, 8}, {-slope, 0, -1});
      ray = intersect(scene, ray);
      ASSERT_TRUE(isHit(ray)) << y;
      EXPECT_EQ(ray.ray.tfar, 8) << y;
      EXPECT_GT(ray.hit.Ng_x * ray.hit.Ng_z, 0)
          << "the hit is not on the side of x < 4, at y " << y << ", slope " << slope;
    }
}

void expectHitsOfAFreshScene(const Device& device, RTCScene scene, const SurfaceSettings& settings,
                             const std::vector<RTCRayHit>& rays) {
  std::vector<RTCRayHit> found;
  for (const RTCRayHit& ray : rays) found.push_back(intersect(scene, ray));
  const SurfaceScene fresh(device, cubeCage(), settings);
  for (size_t i = 0; i < rays.size(); i++) {
    const RTCRayHit expected = intersect(fresh, rays[i]);
    ASSERT_EQ(isHit(found[i]), isHit(expected));
    ASSERT_EQ(found[i].ray.tfar, expected.ray.tfar);
  }
}

// Other blocks are then at addresses whose blocks the threads have decoded.
TEST(VertCache, IsInvalidatedWhenASceneIsRebuilt) {
  Device device;
  Displacement displacement;
  SurfaceSettings settings = vert(32);
  settings.displacement = &displacement;
  Scene scene(device, RTC_SCENE_FLAG_DYNAMIC);
  addSurface(device, scene, cubeCage(), settings);
  RTCGeometry geometry = rtcGetGeometry(scene, 0);
  Random random(84);
  const std::vector<RTCRayHit> rays = raysAt(random, 1000);
  for (int build = 0; build < 6; build++) {
    displacement.amplitude = build % 2 ? 0.1f : 0.05f;
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    SCOPED_TRACE(testing::Message() << "build " << build);
    expectHitsOfAFreshScene(device, scene, settings, rays);
    if (HasFatalFailure()) return;
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

// Traces another scene during the build, so that a thread caches its blocks, then releases it, so that this scene
// reuses the memory.
struct TraceBeforeFirstVertex : public Displacement {
  std::function<void()> work;

  static void run(const RTCDisplacementFunctionNArguments* args) {
    TraceBeforeFirstVertex& d = *static_cast<TraceBeforeFirstVertex*>((Displacement*)args->geometryUserPtr);
    if (d.work) std::exchange(d.work, nullptr)();
    apply(args);
  }
};

// Blocks at the same addresses may have been decoded after the build began.
TEST(VertCache, IsInvalidatedWhenMemoryIsReleasedDuringABuild) {
  Device device("threads=1"); // the same thread traces and builds
  Displacement other;
  TraceBeforeFirstVertex displacement;
  displacement.amplitude = 0.1f;
  SurfaceSettings settings = vert(32);
  Random random(85);
  const std::vector<RTCRayHit> rays = raysAt(random, 1000);
  for (int build = 0; build < 12; build++) { // not every build reuses the same addresses
    settings.displacement = &other;
    std::optional<SurfaceScene> old(std::in_place, device, cubeCage(), settings);
    settings.displacement = &displacement;
    Scene scene(device);
    RTCGeometry geometry = newSurface(device, cubeCage(), settings);
    rtcSetGeometryDisplacementFunction(geometry, TraceBeforeFirstVertex::run);
    attach(scene, geometry);
    displacement.work = [&]() {
      for (const RTCRayHit& ray : rays) intersect(*old, ray);
      old.reset();
    };
    rtcCommitScene(scene);
    ASSERT_FALSE(old);
    SCOPED_TRACE(testing::Message() << "build " << build);
    expectHitsOfAFreshScene(device, scene, settings, rays);
    if (HasFatalFailure()) return;
  }
  EXPECT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
}

}} // namespace programs::test
