// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Neighboring faces with different edge rates share borders without gaps: rays from inside at every vertex of every
 * border and between vertices hit, in every representation. */

#include "support/edge_rates.h"
#include "support/scene_blocks.h"
#include "support/vert_triangles.h"
#include "support/vertex_recorder.h"

#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <tuple>
#include <utility>

namespace programs::test { namespace {

// Records the vertices on the borders of all patches, by their parameter along the side.
struct BorderRecorder : public VertexRecorder {
  typedef std::tuple<unsigned, unsigned, unsigned> Side; // face, sub-patch, side of the patch
  std::map<Side, std::map<float, Vec>> borders;
  const Cage& cage;

  explicit BorderRecorder(const Cage& cage) : cage(cage) {}

  void record(const RTCDisplacementFunctionNArguments& args) override {
    for (unsigned i = 0; i < args.N; i++) {
      float u = args.u[i], v = args.v[i];
      unsigned sub = 0;
      if (cage.faces[args.primID] != 4) { // corner k of an n-gon is at (2 (k%4) + 1/2, 2 (k/4) + 1/2)
        const float su = std::floor((u - 0.25f) / 2), sv = std::floor((v - 0.25f) / 2);
        sub = unsigned(su + 4 * sv);
        u -= 2 * su + 0.5f;
        v -= 2 * sv + 0.5f;
      }
      const Vec p = {args.P_x[i], args.P_y[i], args.P_z[i]};
      if (v == 0) borders[Side(args.primID, sub, 0)][u] = p;
      if (u == 1) borders[Side(args.primID, sub, 1)][v] = p;
      if (v == 1) borders[Side(args.primID, sub, 2)][u] = p;
      if (u == 0) borders[Side(args.primID, sub, 3)][v] = p;
    }
  }

  // Every vertex of the borders and points between neighbors.
  std::vector<Vec> targets(Random& random, unsigned pointsBetween) const {
    std::vector<Vec> out;
    for (const auto& border : borders) {
      const Vec* last = nullptr;
      for (const auto& vertex : border.second) {
        for (unsigned i = 0; last && i < pointsBetween; i++) {
          const double t = random.uniform();
          Vec p;
          for (int k = 0; k < 3; k++) p[k] = float((*last)[k] + t * (double(vertex.second[k]) - (*last)[k]));
          out.push_back(p);
        }
        out.push_back(vertex.second);
        last = &vertex.second;
      }
    }
    return out;
  }

  // Halfway between these borders and those of a finer tessellation, where a face that kept all its vertices would
  // leave a hole.
  std::vector<Vec> targetsNextTo(const BorderRecorder& fine) const {
    std::vector<Vec> out;
    for (const auto& border : borders)
      for (const auto& vertex : fine.borders.at(border.first)) {
        const auto after = border.second.upper_bound(vertex.first);
        if (after == border.second.begin() || after == border.second.end()) continue;
        const auto before = std::prev(after);
        const double t = (vertex.first - before->first) / (after->first - before->first);
        Vec p;
        for (int k = 0; k < 3; k++)
          p[k] = float(0.5 * (vertex.second[k] + before->second[k] + t * (after->second[k] - before->second[k])));
        out.push_back(p);
      }
    return out;
  }
};

// Vertices of the patch of a face, as stored in cGRID.
struct PatchVertices {
  unsigned quadsX = 0, quadsY = 0;
  std::map<std::pair<unsigned, unsigned>, Vec> vertices; // column, row

  PatchVertices(const std::vector<const embree::cbvh::Block*>& blocks, unsigned face) {
    for (const embree::cbvh::Block* block : blocks) {
      if (block->primID != face) continue;
      EXPECT_EQ(block->kind(), embree::cbvh::Kind::CGRID);
      quadsX = block->quadsX();
      quadsY = block->quadsY();
      const unsigned size = 1u << block->height(), width = size + 1;
      const float* p = (const float*)block->leaves();
      for (unsigned i = 0; i < width * width; i++) {
        const unsigned x = embree::cbvh::blockXOf(block->info) * size + i % width,
                       y = embree::cbvh::blockYOf(block->info) * size + i / width;
        vertices[{x, y}] = {p[i], p[width * width + i], p[2 * width * width + i]};
      }
    }
  }

  // Sides in the order of the edges of a face.
  unsigned quadsOf(unsigned side) const { return side % 2 ? quadsY : quadsX; }
  const Vec& onSide(unsigned side, unsigned i, unsigned inward = 0) const {
    switch (side) {
    case 0: return vertices.at({i, inward});
    case 1: return vertices.at({quadsX - inward, i});
    case 2: return vertices.at({i, quadsY - inward});
    default: return vertices.at({inward, i});
    }
  }
};

// True if two evaluations of a vertex are equal except for rounding.
bool isSameVertex(const Vec& a, const Vec& b) {
  bool same = true;
  for (int k = 0; k < 3; k++) same &= std::fabs(a[k] - b[k]) <= 8 * std::numeric_limits<float>::epsilon();
  return same;
}

/* Borders on edges of a lower rate (kernels/cbvh/paper/README.md): each vertex of the edge is at the nearest vertex of
 * the patch. The vertices between are evenly spaced on the straight line, shifted outward by at most 2^-20. */
void expectPolyline(const PatchVertices& patch, unsigned side, const std::vector<Vec>& own) {
  const unsigned fine = patch.quadsOf(side), coarse = unsigned(own.size()) - 1;
  std::vector<unsigned> at; // positions of the edge's vertices among those of the patch
  for (unsigned k = 0; k <= coarse; k++) {
    // in a tie two vertices are nearest
    const unsigned below = (2 * k * fine + coarse - 1) / (2 * coarse), above = (2 * k * fine + coarse) / (2 * coarse);
    const bool isBelow = isSameVertex(patch.onSide(side, below), own[k]);
    ASSERT_TRUE(isBelow || isSameVertex(patch.onSide(side, above), own[k]))
        << "vertex " << k << " of " << coarse << " is not a vertex of the patch";
    at.push_back(isBelow ? below : above);
  }
  for (unsigned k = 0; k < coarse; k++)
    for (unsigned i = at[k] + 1; i < at[k + 1]; i++) {
      const double t = double(i - at[k]) / (at[k + 1] - at[k]);
      const Vec &p = patch.onSide(side, i), &inner = patch.onSide(side, i, 1);
      double off = 0, size = 0, outward = 0;
      for (int j = 0; j < 3; j++) {
        const double line = own[k][j] + t * (double(own[k + 1][j]) - own[k][j]);
        off = std::max(off, std::fabs(p[j] - line));
        size = std::max(size, std::fabs(line));
        outward += (p[j] - line) * (line - inner[j]);
      }
      ASSERT_LE(off, size * 0x1p-20 + 8 * std::numeric_limits<float>::epsilon()) << "vertex " << i << " of " << fine;
      ASSERT_GE(outward, -8 * std::numeric_limits<float>::epsilon()) << "vertex " << i << " of " << fine;
    }
}

TEST(BordersOfMixedRates, ArePolylinesOfTheirEdges) {
  Device device;
  const Cage cage = cubeCage();
  unsigned lower = 0;
  for (unsigned seed = 64; seed < 72; seed++) {
    Random random(seed);
    BorderRecorder recorder(cage);
    SurfaceSettings settings;
    settings.edgeRates = drawRates(cage, random, [](Random& r) { return float(1 + r.below(r.chance(0.5) ? 8 : 40)); });
    settings.compression = RTC_COMPRESSION_NONE;
    Scene grid(device);
    recorder.build(device, grid, cage, settings);
    settings.displacement = &recorder;
    settings.compression = RTC_COMPRESSION_CGRID;
    const SurfaceScene scene(device, cage, settings);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    const std::vector<const embree::cbvh::Block*> blocks = sceneBlocks(scene);
    for (unsigned face = 0; face < 6; face++) {
      const PatchVertices patch(blocks, face);
      for (unsigned side = 0; side < 4; side++) {
        const unsigned rate = unsigned(settings.edgeRates[4 * face + side]);
        SCOPED_TRACE(testing::Message() << "seed " << seed << ", face " << face << ", side " << side << ", rate "
                                        << rate << " of " << patch.quadsOf(side));
        std::vector<Vec> own;
        for (unsigned k = 0; k <= rate; k++) {
          const auto& border = recorder.borders.at(BorderRecorder::Side(face, 0, side));
          const auto vertex = border.lower_bound(float(k) / float(rate) - 1e-5f);
          ASSERT_TRUE(vertex != border.end() && std::fabs(vertex->first - float(k) / float(rate)) < 1e-5f);
          own.push_back(vertex->second);
        }
        expectPolyline(patch, side, own);
        if (HasFatalFailure()) return;
        lower += rate < patch.quadsOf(side);
      }
    }
  }
  EXPECT_GT(lower, 100u);
}

class MixedRates : public testing::TestWithParam<RTCCompression> {};
INSTANTIATE_TEST_SUITE_P(Compression, MixedRates,
                         testing::Values(RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF,
                                         RTC_COMPRESSION_CVERT),
                         nameOf);

std::vector<RTCRayHit> raysTowards(const std::vector<Vec>& targets, Random& random) {
  std::vector<RTCRayHit> rays;
  for (const Vec& target : targets) {
    Vec o, d;
    for (int k = 0; k < 3; k++) {
      o[k] = float(random.uniform(-0.2, 0.2));
      d[k] = target[k] - o[k];
    }
    rays.push_back(makeRay(o, d));
  }
  return rays;
}

// Point of the surface without displacement. Interpolation reads one float after the last vertex.
Vec surfacePoint(RTCScene scene, const Cage& cage, unsigned face, float u, float v) {
  const RTCGeometry geometry = rtcGetGeometry(scene, 0);
  ((float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0))[3 * cage.positions.size()] = 0;
  Vec p;
  rtcInterpolate0(geometry, face, u, v, RTC_BUFFER_TYPE_VERTEX, 0, p.data(), 3);
  return p;
}

/* A border consists of points of the surface (rtcInterpolate) at its own rate, whatever the rates of other edges. */
TEST(BordersOfMixedRates, CVertEvaluatesBordersAtTheirRates) {
  Device device;
  Cage bilinear = cubeCage();
  bilinear.mode = RTC_SUBDIVISION_MODE_PIN_ALL;
  for (const Cage& cage : {cubeCage(), creasedCube(), trapezohedronCage(9), bilinear})
    for (const auto& set : rateSets) {
      SCOPED_TRACE(testing::Message() << cage.faces.size() << " faces, rates " << set.name);
      Random random(95);
      SurfaceSettings settings;
      settings.compression = RTC_COMPRESSION_CVERT;
      settings.edgeRates = drawRates(cage, random, set.draw);
      const SurfaceScene scene(device, cage, settings);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      std::vector<std::vector<std::array<float, 3>>> vertices(cage.faces.size());
      for (const VertTriangle& t : vertTriangles(scene))
        vertices[t.primID].insert(vertices[t.primID].end(), t.vertices.begin(), t.vertices.end());
      const double most =
          0.8661 * statisticsOf(scene).maxVertexSpacing + 1e-5; // faces round shared vertices differently
      size_t missing = 0, compared = 0;
      for (unsigned face = 0; face < cage.faces.size(); face++)
        for (unsigned side = 0; side < 4; side++) {
          const unsigned rate = unsigned(std::ceil(settings.edgeRates[4 * face + side]));
          for (unsigned k = 0; k < rate; k++, compared++) {
            const float along = float(k) / float(rate), u[4] = {along, 1, 1 - along, 0},
                        v[4] = {0, along, 1, 1 - along};
            const Vec p = surfacePoint(scene, cage, face, u[side], v[side]);
            missing += std::none_of(vertices[face].begin(), vertices[face].end(), [&](const std::array<float, 3>& q) {
              return std::sqrt(std::pow(q[0] - p[0], 2) + std::pow(q[1] - p[1], 2) + std::pow(q[2] - p[2], 2)) <= most;
            });
          }
        }
      EXPECT_GT(compared, 24u);
      EXPECT_EQ(missing, 0u) << "of " << compared;
    }
}

// Largest distance between a hit and the point of the surface (rtcInterpolate) at its u and v.
double worstOfParameters(RTCScene scene, const Cage& cage, const std::vector<RTCRayHit>& rays) {
  double worst = 0;
  size_t hits = 0;
  for (const RTCRayHit& ray : rays) {
    const RTCRayHit found = intersect(scene, ray);
    if (!isHit(found)) continue;
    const Vec p = surfacePoint(scene, cage, found.hit.primID, found.hit.u, found.hit.v);
    const float org[3] = {ray.ray.org_x, ray.ray.org_y, ray.ray.org_z},
                dir[3] = {ray.ray.dir_x, ray.ray.dir_y, ray.ray.dir_z};
    double d2 = 0;
    for (int k = 0; k < 3; k++) d2 += std::pow(org[k] + double(found.ray.tfar) * dir[k] - p[k], 2);
    worst = std::max(worst, std::sqrt(d2));
    hits++;
  }
  EXPECT_GT(hits, rays.size() / 2);
  return worst;
}

/* Also where a face has a border of a lower rate than its own. GRID's parameters are off by the distance of its
 * triangles from the surface. */
TEST(BordersOfMixedRates, HitsHaveParametersOfTheirPositions) {
  Device device;
  for (const auto& cage : closedCages)
    for (unsigned seed = 91; seed < 94; seed++) {
      SCOPED_TRACE(testing::Message() << cage.name << ", seed " << seed);
      Random random(seed);
      BorderRecorder recorder(cage.cage);
      recorder.amplitude = 0;
      SurfaceSettings settings;
      for (size_t i = 0; i < cage.cage.indices.size(); i++) settings.edgeRates.push_back(float(4 + random.below(40)));
      settings.compression = RTC_COMPRESSION_NONE;
      Scene grid(device);
      recorder.build(device, grid, cage.cage, settings);
      settings.compression = RTC_COMPRESSION_CVERT;
      const SurfaceScene scene(device, cage.cage, settings);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      const std::vector<RTCRayHit> rays = raysTowards(recorder.targets(random, 3), random);
      EXPECT_LE(worstOfParameters(scene, cage.cage, rays), 2 * worstOfParameters(grid, cage.cage, rays))
          << "of " << rays.size() << " rays";
    }
}

unsigned countMisses(RTCScene scene, const std::vector<RTCRayHit>& rays) {
  unsigned misses = 0;
  for (const RTCRayHit& ray : rays) {
    const bool hit = isHit(intersect(scene, ray));
    EXPECT_EQ(occluded(scene, ray), hit) << "any hit differs from closest hit";
    misses += !hit;
  }
  return misses;
}

/* Rays at the vertices of borders, between them and next to them (targetsNextTo) hit. Some pass between triangles by
 * Embree's triangle test, which cGRID also uses: over all scenes together not more than in GRID. */
TEST_P(MixedRates, NeighborsAreClosedWithoutGridFallback) {
  Device device;
  unsigned leaks = 0, gridLeaks = 0;
  for (const auto& cage : closedCages)
    for (const auto& set : rateSets)
      for (int frameLevel : {0, 2, RTC_COMPRESSION_FRAME_LEVEL_INHERIT}) {
        SCOPED_TRACE(testing::Message() << cage.name << ", rates " << set.name << ", frame level " << frameLevel);
        Random random(61);
        BorderRecorder recorder(cage.cage);
        SurfaceSettings settings;
        settings.edgeRates = drawRates(cage.cage, random, set.draw);
        settings.frameLevel = frameLevel;
        settings.compression = RTC_COMPRESSION_NONE;
        Scene grid(device);
        recorder.build(device, grid, cage.cage, settings);
        settings.displacement = &recorder;
        settings.compression = GetParam();
        const SurfaceScene scene(device, cage.cage, settings);
        ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
        const RTCCompressionStatistics stats = statisticsOf(scene);
        EXPECT_GT(stats.numQuads, 0u);
        EXPECT_EQ(stats.numUncompressedQuads, 0u);
        EXPECT_EQ(stats.numInvalidQuads, 0u);
        BorderRecorder fine(cage.cage);
        Scene fineGrid(device);
        settings.edgeRates.clear();
        settings.rate = 64;
        settings.compression = RTC_COMPRESSION_NONE;
        fine.build(device, fineGrid, cage.cage, settings);
        const std::vector<RTCRayHit> rays = raysTowards(recorder.targets(random, 3), random);
        const std::vector<RTCRayHit> beside = raysTowards(recorder.targetsNextTo(fine), random);
        const unsigned misses = countMisses(scene, rays), missesNextTo = countMisses(scene, beside);
        if (GetParam() != RTC_COMPRESSION_CGRID) {
          EXPECT_EQ(misses, 0u) << "of " << rays.size();
          EXPECT_EQ(missesNextTo, 0u) << "of " << beside.size();
        }
        leaks += misses + missesNextTo;
        gridLeaks += countMisses(grid, rays) + countMisses(grid, beside);
      }
  EXPECT_LE(leaks, gridLeaks);
}

// One edge of rate 300: in kinds with frames its two faces are left to GRID; the others are compressed.
TEST_P(MixedRates, CompressedFacesAreClosedNextToHighRates) {
  Device device;
  const Cage cage = cubeCage();
  Random random(62);
  bool first = true;
  BorderRecorder recorder(cage);
  SurfaceSettings settings;
  settings.edgeRates =
      drawRates(cage, random, [&](Random& r) { return std::exchange(first, false) ? 300.0f : float(1 + r.below(40)); });
  settings.compression = RTC_COMPRESSION_NONE;
  Scene grid(device);
  recorder.build(device, grid, cage, settings);
  settings.displacement = &recorder;
  settings.compression = GetParam();
  const SurfaceScene scene(device, cage, settings);
  const RTCCompressionStatistics stats = statisticsOf(scene);
  EXPECT_GT(stats.numQuads, 0u);
  const bool isVert = GetParam() == RTC_COMPRESSION_CVERT;
  EXPECT_EQ(stats.numUncompressedQuads > 0, !isVert);
  const std::vector<RTCRayHit> rays = raysTowards(recorder.targets(random, 3), random);
  EXPECT_LE(countMisses(scene, rays), isVert ? 0 : countMisses(grid, rays)) << "of " << rays.size();
}

}} // namespace programs::test
