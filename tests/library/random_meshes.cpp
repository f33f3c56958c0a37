// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Partly regular meshes of quads and triangles with errors: each primitive that Embree traces must be stored exactly
 * once, with its own vertices. Buffers end at most 4 bytes after the range that the API requires, for
 * sanitizers.
 *
 *   CBVH_RANDOM_GEOMETRIES=100000 random_meshes    for a longer run */

#include "support/diced_mesh.h"
#include "support/random_rounds.h"
#include "support/surface_access.h"

#include <cstdio>
#include <memory>
#include <set>

namespace programs::test { namespace {

// Sheets that may be welded, cut, rotated, twisted and shuffled.
DicedMesh randomMesh(Random& random) {
  DicedMesh mesh;
  const double scale = random.magnitude(1e-4, 1e4);
  for (unsigned sheet = 0, sheets = 1 + random.below(5); sheet < sheets; sheet++) {
    const unsigned w = 1 + random.below(random.chance(0.2) ? 150 : 40), h = 1 + random.below(40),
                   first = unsigned(mesh.vertices.size());
    const bool isRing = random.chance(0.2), isTurned = random.chance(0.3);
    const auto vertex = [&](unsigned x, unsigned y) { return first + y * (w + 1) + (isRing ? x % w : x); };
    for (unsigned y = 0; y <= h; y++)
      for (unsigned x = 0; x <= w; x++)
        mesh.vertices.push_back({float(scale * (x + 0.2 * random.uniform())),
                                 float(scale * (y + 0.2 * random.uniform())),
                                 float(scale * (50.0 * sheet + 0.3 * random.normal()))});
    for (unsigned y = 0; y < h; y++)
      for (unsigned x = 0; x < w; x++) {
        std::array<unsigned, 4> q = {vertex(x, y), vertex(x + 1, y), vertex(x + 1, y + 1), vertex(x, y + 1)};
        std::rotate(q.begin(), q.begin() + (isTurned ? 1 : random.chance(0.01) ? random.below(4) : 0), q.end());
        if (random.chance(0.005)) std::swap(q[1], q[3]);
        if (random.chance(0.005)) q[random.below(4)] = random.below(unsigned(mesh.vertices.size()));
        if (random.chance(0.002))
          q[random.below(4)] = random.chance(0.5) ? random.bits() : unsigned(mesh.vertices.size());
        if (!random.chance(0.01)) mesh.quads.push_back(q);
        if (random.chance(0.003)) mesh.quads.push_back(q); // a duplicate
      }
  }
  const auto shuffle = [&](auto& faces) {
    const size_t swaps = random.chance(0.5) ? 0 : random.chance(0.5) ? 10 : faces.size();
    for (size_t i = 0; i < swaps && faces.size() > 1; i++)
      std::swap(faces[random.below(unsigned(faces.size()))], faces[random.below(unsigned(faces.size()))]);
  };
  shuffle(mesh.quads);
  if (random.chance(0.5)) {
    mesh = trianglesOf(mesh, random.below(3), random.below(3));
    for (unsigned i = random.below(5); i > 0; i--)
      mesh.triangles.erase(mesh.triangles.begin() + random.below(unsigned(mesh.triangles.size())));
    if (random.chance(0.2)) shuffle(mesh.triangles);
    if (random.chance(0.2)) mesh = halvesApart(mesh);
    if (random.chance(0.2)) mesh = withShuffledFaces(mesh, random);
    if (random.chance(0.2)) mesh = withTurnedTriangles(mesh, random);
  }
  if (random.chance(0.3))
    for (unsigned i = random.below(10); i > 0; i--)
      mesh.vertices[random.below(unsigned(mesh.vertices.size()))][random.below(3)] =
          random.chance(0.5) ? NAN : INFINITY;
  return mesh;
}

// A buffer with a stride, and 4 more bytes, which Embree may read after the last vertex.
struct Strided {
  size_t stride;
  std::unique_ptr<char[]> bytes;

  template<typename Item>
  Strided(Random& random, const std::vector<Item>& items)
    : stride(sizeof(Item) + 4 * random.below(3)),
      bytes(new char[items.size() * stride + 4]) {
    for (size_t i = 0; i < items.size(); i++) std::memcpy(&bytes[i * stride], &items[i], sizeof(Item));
  }
};

TEST(RandomMeshes, EachPrimitiveIsStoredOnce) {
  Random random(141);
  const size_t rounds = randomRounds(150);
  size_t compressed = 0, primitives = 0, irregular = 0;
  for (size_t round = 0; round < rounds; round++) {
    SCOPED_TRACE(testing::Message() << "round " << round);
    Device device("threads=2");
    const DicedMesh mesh = randomMesh(random);
    if (mesh.size() == 0) continue;
    const Strided vertices(random, mesh.vertices),
        indices = mesh.isTriangleForm() ? Strided(random, mesh.triangles) : Strided(random, mesh.quads);
    RTCGeometry geometry =
        rtcNewGeometry(device, mesh.isTriangleForm() ? RTC_GEOMETRY_TYPE_TRIANGLE : RTC_GEOMETRY_TYPE_QUAD);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices.bytes.get(), 0,
                               vertices.stride, mesh.vertices.size());
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0,
                               mesh.isTriangleForm() ? RTC_FORMAT_UINT3 : RTC_FORMAT_UINT4, indices.bytes.get(), 0,
                               indices.stride, mesh.size());
    commitAs(geometry, RTC_COMPRESSION_CVERT, random.chance(0.3) ? RTC_COMPRESSION_FLAG_RELEASE_INPUT : 0);
    Scene scene(device);
    attach(scene, geometry);
    rtcCommitScene(scene);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    for (int i = 0; i < 20; i++) intersect(scene, rayAt(random, meshOf(dicedSheet(1, 4), QuadOrder::Rows, random)));
    const RTCCompressionStatistics stats = statisticsOf(scene);
    if (stats.numQuads == 0) continue; // left to Embree because that needs less memory

    const unsigned corners = mesh.isTriangleForm() ? 3 : 4;
    const auto indexOf = [&](size_t i) {
      return mesh.isTriangleForm() ? mesh.triangles[i].data() : mesh.quads[i].data();
    };
    const auto isValid = [&](const unsigned* v) {
      return std::all_of(v, v + corners, [&](unsigned k) { return k < mesh.vertices.size(); });
    };
    const auto isFinite = [&](unsigned k) {
      return std::isfinite(mesh.vertices[k][0] + mesh.vertices[k][1] + mesh.vertices[k][2]);
    };
    // the triangle that contains the point (u,u); mesh blocks may leave it out if it has no area
    const unsigned halves[2][3] = {{0, 1, corners == 3 ? 2u : 3u}, {2, 3, 1}};
    const auto hasArea = [&](const unsigned* v, float u) {
      const unsigned* half = halves[u > 0.5f];
      double e[2][3];
      for (int k = 0; k < 3; k++)
        for (int i = 0; i < 2; i++) e[i][k] = double(mesh.vertices[v[half[i + 1]]][k]) - mesh.vertices[v[half[0]]][k];
      return e[0][0] * e[1][1] != e[0][1] * e[1][0] || e[0][1] * e[1][2] != e[0][2] * e[1][1] ||
             e[0][2] * e[1][0] != e[0][0] * e[1][2];
    };
    std::set<unsigned> met;
    forEachStoredPart(
        geometry, 0,
        [](void* userPtr, const CbvhPart* part) {
          const unsigned n = part->primitivesPerQuad;
          for (unsigned i = 0; i < (part->width - 1) * (part->height - 1) * n; i++)
            if (n == 1 || i % 2 == 0 || part->primIDs[i] != part->primIDs[i - 1]) {
              EXPECT_TRUE(((std::set<unsigned>*)userPtr)->insert(part->primIDs[i]).second)
                  << "stored twice: " << part->primIDs[i];
            }
          return true;
        },
        &met);
    size_t there = 0;
    for (size_t i = 0; i < mesh.size(); i++) {
      const unsigned* v = indexOf(i);
      const bool mayBeLeftOut = !isValid(v) || !std::all_of(v, v + corners, isFinite);
      if (!mayBeLeftOut && (hasArea(v, 0.3f) || (corners == 4 && hasArea(v, 0.8f)))) {
        ASSERT_TRUE(met.count(unsigned(i))) << i;
      }
      if (!isValid(v)) { ASSERT_FALSE(met.count(unsigned(i))) << i; }
      if (mayBeLeftOut) continue;
      there++;
      for (float u : {0.3f, 0.8f}) {
        if ((mesh.isTriangleForm() && u > 0.5f) || !hasArea(v, u)) continue;
        CbvhTriangle t;
        ASSERT_TRUE(findStoredTriangle(geometry, 0, unsigned(i), u, u, nullptr, &t));
        for (int c = 0; c < 3; c++) {
          const Vec& p = mesh.vertices[v[halves[u > 0.5f][c]]];
          for (int k = 0; k < 3; k++)
            ASSERT_NEAR(t.vertices[c][k], p[k], stats.maxVertexSpacing) << "primitive " << i << ", vertex " << c;
        }
      }
    }
    compressed++;
    primitives += there;
    irregular += stats.numIrregularQuads;
  }
  std::printf("%zu of %zu meshes compressed, %zu primitives in them, %zu quads irregular\n", compressed, rounds,
              primitives, irregular);
  EXPECT_GT(compressed, rounds / 4);
  EXPECT_GT(irregular, 0u);
}

}} // namespace programs::test
