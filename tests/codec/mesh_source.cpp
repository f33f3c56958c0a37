// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Conversion of meshes to blocks: clusters, lattices, and skipped triangles. Movements of vertices are computed in long
 * double, independently of the library's lattice. */

#include "kernels/cvert/encoder/mesh_blocks.h"
#include "kernels/cvert/decoder/decoded_mesh.h"
#include "kernels/cvert/decoder/validate_mesh.h"
#include "support/random.h"

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <memory>
#include <set>
#include <vector>

namespace programs::test { namespace {

using namespace cvert;

constexpr uint32_t seed = 42;

typedef std::array<float, 3> Point;
typedef std::array<uint32_t, 3> Corners;

struct Mesh {
  std::vector<Point> points;
  std::vector<Corners> triangles;

  MeshSource source() const {
    return {(const float(*)[3])points.data(), points.size(), (const uint32_t(*)[3])triangles.data(), triangles.size()};
  }
  void unweld() {
    Mesh mesh;
    for (Corners& t : triangles) {
      for (uint32_t& v : t) {
        mesh.points.push_back(points[v]);
        v = uint32_t(mesh.points.size() - 1);
      }
      mesh.triangles.push_back(t);
    }
    *this = mesh;
  }
};

// Triangles of blocks by primID, with their stored corners.
struct Stored {
  MeshReport report;
  std::map<uint32_t, std::array<Point, 3>> triangles;
  size_t blocks = 0;

  Stored(const Mesh& mesh, int exponent, uint32_t groupTriangles = 16) {
    MeshSettings settings;
    settings.exponent = exponent;
    settings.groupTriangles = groupTriangles;
    auto encoder = std::make_unique<MeshBlocks>(settings);
    report = encoder->encode(mesh.source(), [&](const MeshHeader* block) {
      blocks++;
      ASSERT_EQ(validateMesh(block, block->bytes).message(), "");
      const auto decoded = std::make_unique<DecodedMesh>(block);
      for (uint32_t t = 0; t < decoded->numTriangles; t++) {
        std::array<Point, 3> corners;
        for (int c = 0; c < 3; c++)
          std::copy(decoded->vertices[decoded->triangles[t][c]], decoded->vertices[decoded->triangles[t][c]] + 3,
                    corners[c].begin());
        ASSERT_TRUE(triangles.emplace(decoded->numbers[t], corners).second)
            << "triangle " << decoded->numbers[t] << " is stored twice";
      }
    });
  }
};

typedef std::array<long double, 3> Normal;
Normal normal(const Point& a, const Point& b, const Point& c) {
  long double e[3], f[3];
  for (int k = 0; k < 3; k++) {
    e[k] = (long double)b[k] - a[k];
    f[k] = (long double)c[k] - a[k];
  }
  return {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
}
long double dot(const Normal& a, const Normal& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Triangles are stored, or counted as invalid or degenerate. Stored ones do not flip or degenerate. Vertices move by at
// most half a spacing per axis, and equal positions stay equal.
void expectStored(const Mesh& mesh, const Stored& stored, int exponent) {
  const long double most = exponent == losslessExponent ? 0 : std::ldexp(0.5L, exponent);
  std::map<Point, Point> placeOf;
  size_t count = 0;
  for (uint32_t i = 0; i < mesh.triangles.size(); i++) {
    const auto found = stored.triangles.find(i);
    if (found == stored.triangles.end()) continue;
    count++;
    Point own[3];
    for (int c = 0; c < 3; c++) {
      own[c] = mesh.points[mesh.triangles[i][c]];
      for (float& x : own[c]) x += 0.0f; // -0
      for (int k = 0; k < 3; k++)
        ASSERT_LE(std::fabs((long double)found->second[c][k] - own[c][k]), most) << "triangle " << i;
      const auto place = placeOf.emplace(own[c], found->second[c]).first;
      ASSERT_EQ(place->second, found->second[c]) << "a vertex of triangle " << i << " is stored at two positions";
    }
    const Normal before = normal(own[0], own[1], own[2]),
                 after = normal(found->second[0], found->second[1], found->second[2]);
    ASSERT_GT(dot(after, after), 0) << "triangle " << i << " is flat";
    ASSERT_GE(dot(before, after), 0) << "triangle " << i << " is flipped";
  }
  EXPECT_EQ(count, stored.triangles.size());
  EXPECT_EQ(count + stored.report.invalidTriangles + stored.report.degenerateTriangles, mesh.triangles.size());
  EXPECT_EQ(stored.report.statistics.triangles, count);
  EXPECT_EQ(stored.report.statistics.blocks, stored.blocks);
}

// A closed, noisy torus of 2 n^2 triangles.
Mesh torus(Random& random, uint32_t n, double noise) {
  Mesh mesh;
  for (uint32_t y = 0; y < n; y++)
    for (uint32_t x = 0; x < n; x++) {
      const double s = 2 * M_PI * x / n, t = 2 * M_PI * y / n, r = 3 + std::cos(t) + noise * random.normal();
      mesh.points.push_back(
          {float(r * std::cos(s)), float(r * std::sin(s)), float(std::sin(t) + noise * random.normal())});
    }
  for (uint32_t y = 0; y < n; y++)
    for (uint32_t x = 0; x < n; x++) {
      const uint32_t a = y * n + x, b = y * n + (x + 1) % n, c = (y + 1) % n * n + x, d = (y + 1) % n * n + (x + 1) % n;
      mesh.triangles.push_back({a, b, d});
      mesh.triangles.push_back({d, c, a});
    }
  return mesh;
}

TEST(MeshSource, VerticesMoveByHalfASpacingAndSurfacesStayClosed) {
  Random random(seed);
  for (int exponent : {-14, -10, -7, losslessExponent})
    for (bool welded : {true, false}) {
      Mesh mesh = torus(random, 60, 0.01);
      if (!welded) mesh.unweld();
      const Stored stored(mesh, exponent, welded ? 16 : 32);
      expectStored(mesh, stored, exponent);
      EXPECT_EQ(stored.triangles.size(), 7200u);
      EXPECT_LT(stored.report.statistics.vertices, 0.75 * 7200);
    }
}

// The fast test must be conservative: it never accepts a triangle that flips.
TEST(MeshSource, RobustTrianglesDoNotFlip) {
  Random random(seed + 6);
  size_t robust = 0;
  for (int i = 0; i < 300000; i++) {
    const int exponent = std::vector<int>{-100, -40, -8, 0, 40}[i % 5];
    const MeshLattice lattice(i % 7 == 0 ? losslessExponent : exponent);
    const double size = random.magnitude(0.1, 1e5), flatness = random.magnitude(1e-6, 1),
                 far = random.chance(0.5) ? 0 : random.magnitude(1, 1e7);
    double axis[2][3], origin[3];
    for (int k = 0; k < 3; k++) {
      origin[k] = far * random.normal();
      for (auto& a : axis) a[k] = random.normal();
    }
    Point p[3], q[3];
    for (int c = 0; c < 3; c++) {
      const double u = random.normal(), v = flatness * random.normal();
      for (int k = 0; k < 3; k++)
        p[c][k] = float(std::ldexp(origin[k] + size * (u * axis[0][k] + v * axis[1][k]), exponent));
      lattice.snap(p[c].data(), q[c].data());
    }
    if (!lattice.isRobust(p[0].data(), p[1].data(), p[2].data())) continue;
    robust++;
    ASSERT_GT(dot(normal(p[0], p[1], p[2]), normal(q[0], q[1], q[2])), 0) << "triangle " << i;
  }
  EXPECT_GT(robust, 30000u);
}

// Needles, and triangles not much larger than the spacing. Many of them would flip or degenerate.
TEST(MeshSource, NoTriangleFlipsOrDegenerates) {
  Random random(seed + 1);
  size_t finer = 0;
  for (int exponent : {-6, -4, -3}) {
    const Mesh mesh = torus(random, 60, 0.03);
    const Stored stored(mesh, exponent);
    expectStored(mesh, stored, exponent);
    EXPECT_EQ(stored.triangles.size(), 7200u);
    finer += stored.report.finerVertices;
  }
  EXPECT_GT(finer, 1000u);
  Mesh needles;
  for (uint32_t i = 0; i < 1000; i++) {
    const float x = float(random.uniform(0, 100)), y = float(random.uniform(0, 100)), z = float(random.uniform(0, 1));
    // aspect 1e6
    needles.points.insert(needles.points.end(), {{x, y, z}, {x + 50, y + 20, z}, {x + 50, y + 20 + 5e-5f, z + 5e-5f}});
    needles.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
  }
  const Stored stored(needles, -7);
  expectStored(needles, stored, -7);
  EXPECT_GT(stored.report.finerVertices, 1000u);
  // all vertices are on the lattice unless finer ones are required
  EXPECT_EQ(Stored(torus(random, 60, 0), -12).report.finerVertices, 0u);
}

// Also for positions with few bits, whose hashes differ in few bits before they are mixed.
TEST(MeshSource, ExceptionsAreFoundAmongMany) {
  Random random(seed + 8);
  for (unsigned side : {4u, 100u, 1u << 24}) {
    std::map<std::array<uint32_t, 3>, uint32_t> expected;
    MeshExceptions exceptions;
    const auto position = [&] {
      const float p[3] = {float(random.below(side)), float(random.below(side)), float(random.below(side)) - 7};
      return MeshPosition(p);
    };
    for (int i = 0; i < 50000; i++) {
      const MeshPosition p = position();
      const uint32_t level = 1 + random.below(2);
      uint32_t& of = expected[{p.words[0], p.words[1], p.words[2]}];
      of = std::max(of, level);
      exceptions.raise(p, p.hash(), level);
      const MeshPosition q = position();
      const auto found = expected.find({q.words[0], q.words[1], q.words[2]});
      ASSERT_EQ(exceptions.levelOf(q, q.hash()), found == expected.end() ? 0 : found->second);
    }
    EXPECT_EQ(exceptions.size(), expected.size());
    for (const auto& e : expected) {
      MeshPosition p;
      std::copy(e.first.begin(), e.first.end(), p.words);
      ASSERT_EQ(exceptions.levelOf(p, p.hash()), e.second);
    }
  }
}

TEST(MeshSource, TrianglesThatCannotBeHitAreSkippedAndCounted) {
  Mesh mesh;
  mesh.points = {{0, 0, 0},        {1, 0, 0},     {0, 1, 0}, {NAN, 0, 0},
                 {0, INFINITY, 0}, {1e30f, 0, 0}, {2, 0, 0}, {-0.0f, 0, 0}};
  mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {4, 1, 2}, {0, 5, 2}, {0, 1, 8}, {0, ~0u, 1}, // invalid: 5
                    {0, 0, 1}, {1, 2, 1}, {0, 7, 1},                                    // two equal corners: 3
                    {2, 1, 6}, {0, 1, 6}};                                              // the second one is flat
  const Stored stored(mesh, -10);
  EXPECT_EQ(stored.report.invalidTriangles, 5u);
  EXPECT_EQ(stored.report.degenerateTriangles, 3u);
  ASSERT_EQ(stored.triangles.size(), 3u);
  for (uint32_t i : {0u, 9u, 10u}) EXPECT_EQ(stored.triangles.count(i), 1u) << i;
  mesh.triangles = {{0, 1, 6}};
  EXPECT_EQ(Stored(mesh, -10).blocks, 1u);
  const Stored coarse(mesh, 4); // all corners snap to 0
  EXPECT_EQ(coarse.report.degenerateTriangles, 1u);
  EXPECT_EQ(coarse.blocks, 0u);
  EXPECT_EQ(Stored(Mesh(), -10).blocks, 0u);
}

TEST(MeshSource, AllScalesAreSupported) {
  Random random(seed + 3);
  for (float scale : {1e-30f, 1e-20f, 1e-6f, 1e6f, 1e17f})
    for (bool lattice : {true, false}) {
      Mesh mesh = torus(random, 24, 0.01);
      for (Point& p : mesh.points)
        for (float& x : p) x *= scale;
      const int exponent = lattice ? latticeExponent(0.1 * scale / 2048) : losslessExponent;
      const Stored stored(mesh, exponent);
      expectStored(mesh, stored, exponent);
      EXPECT_EQ(stored.triangles.size(), 1152u);
    }
}

// The square of the spacing underflows, and the lattice would make two corners of a long thin triangle equal.
TEST(MeshSource, TinySpacingsDoNotFlattenLongTriangles) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1e-23f, 0, 0}, {0, 1e6f, 0}};
  mesh.triangles = {{0, 1, 2}};
  const Stored stored(mesh, -75);
  ASSERT_EQ(stored.triangles.size(), 1u);
  EXPECT_NE(stored.triangles.at(0)[0][0], stored.triangles.at(0)[1][0]);
}

// Guards the size of the format. In this mesh the numbers are in the order of the rows.
TEST(MeshSource, BytesPerTriangleStaySmall) {
  Random random(seed + 4);
  const Mesh mesh = torus(random, 160, 0.001);
  const double triangles = double(mesh.triangles.size()), edge = 2 * M_PI * 3 / 160;
  EXPECT_LT(double(Stored(mesh, latticeExponent(edge / 2048), 16).report.statistics.bytes) / triangles, 6.5);
  EXPECT_LT(double(Stored(mesh, latticeExponent(edge / 2048), 32).report.statistics.bytes) / triangles, 6.3);
  EXPECT_LT(double(Stored(mesh, losslessExponent, 16).report.statistics.bytes) / triangles, 8.8);
}

// ends: of each group, the position of its last triangle in the cluster, plus 1.
struct Cluster {
  std::vector<MeshCenter> triangles;
  std::vector<uint32_t> ends;
};

// The triangles are boxes of the given size.
std::vector<Cluster> clustersOf(std::vector<MeshCenter> centers, uint32_t groupTriangles, float size) {
  const std::vector<MeshCenter> boxes = centers;
  std::vector<Cluster> found;
  MeshClusters clusters(groupTriangles);
  clusters.split(
      centers.data(), centers.size(),
      [&](uint32_t i, float lower[3], float upper[3]) {
        for (int k = 0; k < 3; k++) {
          lower[k] = boxes[i].at[k] - 0.5f * size;
          upper[k] = boxes[i].at[k] + 0.5f * size;
        }
      },
      [&](const MeshCenter* cluster, const MeshGroups& groups) {
        found.push_back({{cluster, cluster + groups.numTriangles()}, {groups.ends, groups.ends + groups.count}});
      });
  return found;
}

TEST(MeshClusters, ClustersContainAllTrianglesInNonemptyGroups) {
  Random random(seed + 5);
  for (uint32_t groupTriangles : {1u, 8u, 16u, 32u})
    for (size_t count : {size_t(0), size_t(1), size_t(255), size_t(256), size_t(257), size_t(5000), size_t(20000)})
      for (int kind = 0; kind < 4; kind++) {
        std::vector<MeshCenter> centers(count);
        for (size_t i = 0; i < count; i++) {
          centers[i].index = uint32_t(i);
          // equal centers, no structure, few different centers, centers of all magnitudes
          for (float& x : centers[i].at)
            x = kind == 0   ? 1.0f
                : kind == 1 ? float(random.normal())
                : kind == 2 ? float(random.below(3)) * 1e18f
                            : std::ldexp(float(random.normal()), -int(random.below(100)));
        }
        const uint32_t most = MeshClusters(groupTriangles).clusterTriangles;
        std::set<uint32_t> seen;
        const std::vector<Cluster> clusters = clustersOf(centers, groupTriangles, 0.01f);
        for (const Cluster& cluster : clusters) {
          ASSERT_LE(cluster.triangles.size(), most);
          ASSERT_LE(cluster.ends.size(), maxMeshGroups);
          ASSERT_EQ(cluster.ends.back(), cluster.triangles.size());
          for (size_t g = 0; g < cluster.ends.size(); g++) {
            const uint32_t begin = g ? cluster.ends[g - 1] : 0;
            ASSERT_GT(cluster.ends[g], begin);
            ASSERT_LE(cluster.ends[g] - begin, groupTriangles);
          }
          for (const MeshCenter& triangle : cluster.triangles) {
            ASSERT_TRUE(seen.insert(triangle.index).second);
            ASSERT_EQ(0, std::memcmp(triangle.at, centers[triangle.index].at, sizeof(triangle.at)));
          }
        }
        ASSERT_EQ(seen.size(), count);
        // parts of more than a cluster become two clusters
        if (kind < 2) { ASSERT_LE(clusters.size(), count / (most / 2) + 1); }
      }
}

// A group that reached from one component to another would be hit by all rays between them.
TEST(MeshClusters, GroupsDoNotBridgeGaps) {
  Random random(seed + 6);
  for (int repeat = 0; repeat < 20; repeat++) {
    std::vector<MeshCenter> centers;
    std::vector<uint32_t> componentOf;
    for (uint32_t component = 0; component < 60; component++)
      for (uint32_t i = 0, n = 20 + random.below(60); i < n; i++) {
        // components of size 1 in the cells of a grid of size 10
        const uint32_t cell[3] = {component % 4, component / 4 % 4, component / 16};
        MeshCenter center;
        for (int k = 0; k < 3; k++) center.at[k] = 10.0f * float(cell[k]) + float(random.below(1000)) * 0.001f;
        center.index = uint32_t(centers.size());
        centers.push_back(center);
        componentOf.push_back(component);
      }
    uint32_t groups = 0, bridges = 0;
    for (const Cluster& cluster : clustersOf(centers, 16, 0.1f))
      for (size_t g = 0; g < cluster.ends.size(); g++) {
        std::set<uint32_t> components;
        for (uint32_t i = g ? cluster.ends[g - 1] : 0; i < cluster.ends[g]; i++)
          components.insert(componentOf[cluster.triangles[i].index]);
        groups++;
        bridges += components.size() > 1;
      }
    EXPECT_LE(bridges, groups / 6); // two thirds if parts are cut at medians
  }
}

}} // namespace programs::test
