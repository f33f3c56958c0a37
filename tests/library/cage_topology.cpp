// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Unusual cages that Embree supports: more indices than the faces use, holes, faces without edges, edges of three
 * faces. cVERT, and cLEAF with fallback faces, share the borders of faces. They must produce the hits of an equivalent
 * simple cage, and closed surfaces. */

#include "support/edge_rates.h"
#include "support/vert_triangles.h"

#include <malloc.h>

#include <map>

namespace programs::test { namespace {

class CageTopology : public testing::TestWithParam<RTCCompression> {};
INSTANTIATE_TEST_SUITE_P(Compression, CageTopology, testing::Values(RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT),
                         nameOf);

// Fills allocated memory with a byte, so that reads of uninitialized memory have an effect. It would often be zero.
class FilledHeap {
public:
  explicit FilledHeap(int byte) { mallopt(M_PERTURB, ~byte & 0xFF); }
  ~FilledHeap() { mallopt(M_PERTURB, 0); }
};

SurfaceSettings sharedBorders(RTCCompression compression, float rate) {
  SurfaceSettings settings;
  settings.compression = compression;
  settings.fallbackFaces = true;
  settings.rate = rate;
  return settings;
}

/* Expects the same hits in `scene` as in `plain`. faces: the scene's face for each face of the plain cage. */
void expectSameHits(RTCScene scene, RTCScene plain, const std::vector<unsigned>& faces) {
  Random random(111);
  size_t hits = 0;
  for (const RTCRayHit& ray : raysAt(random, 300)) {
    const RTCRayHit found = intersect(scene, ray), expected = intersect(plain, ray);
    ASSERT_EQ(isHit(found), isHit(expected));
    if (!isHit(expected)) continue;
    ASSERT_EQ(found.hit.primID, faces[expected.hit.primID]);
    ASSERT_EQ(found.ray.tfar, expected.ray.tfar);
    ASSERT_EQ(found.hit.u, expected.hit.u);
    ASSERT_EQ(found.hit.v, expected.hit.v);
    hits++;
  }
  EXPECT_GT(hits, 50u);
}

TEST_P(CageTopology, IndicesThatNoFaceUsesAreIgnored) {
  Device device;
  const SurfaceSettings settings = sharedBorders(GetParam(), 16);
  const SurfaceScene plain(device, cubeCage(), settings);
  for (size_t spare : {1, 7, 4096})
    for (int byte = 1; byte <= 20; byte++) {
      SCOPED_TRACE(testing::Message() << spare << " more indices, heap filled with " << 12 * byte);
      Cage cage = cubeCage();
      cage.indices.resize(cage.indices.size() + spare, 0);
      const FilledHeap filled(12 * byte);
      const SurfaceScene scene(device, cage, settings);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      ASSERT_EQ(statisticsOf(scene).numQuads, statisticsOf(plain).numQuads);
      expectSameHits(scene, plain, {0, 1, 2, 3, 4, 5});
      if (HasFatalFailure()) return;
    }
}

// For a face without edges, Embree reads the edges of the next face.
TEST_P(CageTopology, FacesWithoutEdgesAreIgnored) {
  Device device;
  const SurfaceSettings settings = sharedBorders(GetParam(), 16);
  const SurfaceScene plain(device, cubeCage(), settings);
  Cage cage = cubeCage();
  cage.faces = {0, 4, 4, 0, 0, 4, 4, 4, 0, 4};
  for (int byte = 1; byte <= 5; byte++) {
    const FilledHeap filled(50 * byte);
    const SurfaceScene scene(device, cage, settings);
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    EXPECT_EQ(statisticsOf(scene).numQuads, statisticsOf(plain).numQuads);
    expectSameHits(scene, plain, {1, 2, 5, 6, 7, 9});
    if (HasFatalFailure()) return;
  }
}

// Rays from the center of the cube through the middle parts of its faces hit and miss as with GRID. The edges of holes,
// and edges of the additional indices, must have no effect on borders.
TEST_P(CageTopology, OnlyHolesAreOpen) {
  Device device;
  for (const std::vector<unsigned>& holes :
       {std::vector<unsigned>{0}, std::vector<unsigned>{5}, std::vector<unsigned>{1, 2, 3}}) {
    Cage cage = cubeCage();
    cage.holes = holes;
    cage.indices.resize(cage.indices.size() + 5, 0);
    const FilledHeap filled(0xA7);
    const Twins twins(device, cage, sharedBorders(GetParam(), 16));
    ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
    Random random(112);
    size_t hits = 0;
    for (int i = 0; i < 600; i++) {
      Vec d;
      for (float& x : d) x = float(random.uniform(-0.3, 0.3));
      d[i % 3] = i % 2 ? 1.f : -1.f;
      const RTCRayHit ray = makeRay({0, 0, 0}, d), expected = intersect(twins.grid, ray),
                      found = intersect(twins.scene, ray);
      ASSERT_EQ(isHit(found), isHit(expected));
      if (!isHit(expected)) continue;
      EXPECT_EQ(found.hit.primID, expected.hit.primID);
      hits++;
    }
    EXPECT_EQ(hits, 100 * (6 - holes.size()));
  }
}

// --- edges of three faces --------------------------------------------------------------

/* Two chambers. Each is a prism of quads with a cap, or a pyramid of triangles. They share a ring of n edges.
 * Each of these edges belongs to three faces if there is a wall between the chambers, otherwise to two.
 *
 *     x---x---x
 *     |   |   |   prism above, with a cap of n edges
 *     x---x---x   ring, with or without the wall
 *      \  |  /
 *       \ | /     pyramid below
 *         x */
struct Chambers {
  unsigned n;
  bool isPrism[2]; // below, above
  bool hasWall;

  Cage cage() const {
    Cage cage;
    const auto addRing = [&](float z) {
      for (unsigned i = 0; i < n; i++) {
        const double a = 2 * M_PI * i / n;
        cage.positions.push_back({float(std::cos(a)), float(std::sin(a)), z});
      }
    };
    addRing(0);
    if (hasWall) addFace(cage, 0, false);
    for (int above = 0; above < 2; above++) {
      const float z = above ? 1.f : -1.f;
      const unsigned first = unsigned(cage.positions.size());
      if (isPrism[above]) {
        addRing(z);
        addFace(cage, first, !above);
      } else cage.positions.push_back({0, 0, z});
      for (unsigned i = 0; i < n; i++) {
        const unsigned a = above ? i : (i + 1) % n, b = above ? (i + 1) % n : i;
        if (isPrism[above]) cage.addFace({a, b, first + b, first + a});
        else cage.addFace({a, b, first});
      }
    }
    return cage;
  }

  void addFace(Cage& cage, unsigned first, bool reversed) const {
    cage.faces.push_back(n);
    for (unsigned i = 0; i < n; i++) cage.indices.push_back(first + (reversed ? n - 1 - i : i));
  }
};

std::vector<Chambers> chambers(bool hasWall) {
  std::vector<Chambers> all;
  for (unsigned n : {3, 4, 5})
    for (int forms = 0; forms < 4; forms++) all.push_back({n, {(forms & 1) != 0, (forms & 2) != 0}, hasWall});
  return all;
}

// Returns how many quads a face with this number of edges has along one of them if it need not match a neighbor. GRID
// divides faces that are not quads into sub-patches, which halve the edge.
unsigned ownQuads(unsigned edges, float rate) {
  const unsigned n = unsigned(std::ceil(edges == 4 ? rate : 0.5f * rate));
  return edges == 4 ? n : 2 * n;
}

// Returns the number of quads along the ring if each of its edges has the lowest ownQuads() of its faces. The ring's
// vertices are the first n vertices of the cage.
size_t quadsAlongRing(const Cage& cage, unsigned n, const SurfaceSettings& settings) {
  std::map<std::pair<unsigned, unsigned>, unsigned> least;
  size_t begin = 0;
  for (unsigned edges : cage.faces) {
    for (unsigned i = 0; i < edges; i++) {
      const unsigned a = cage.indices[begin + i], b = cage.indices[begin + (i + 1) % edges];
      if (a >= n || b >= n) continue;
      const unsigned quads =
          ownQuads(edges, settings.edgeRates.empty() ? settings.rate : settings.edgeRates[begin + i]);
      const auto known = least.emplace(std::minmax(a, b), quads);
      known.first->second = std::min(known.first->second, quads);
    }
    begin += edges;
  }
  EXPECT_EQ(least.size(), n);
  size_t sum = 0;
  for (const auto& edge : least) sum += edge.second;
  return sum;
}

// Number of triangles that use each edge, in either direction.
std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, unsigned> usesOfEdges(RTCScene scene) {
  std::map<std::pair<std::array<float, 3>, std::array<float, 3>>, unsigned> uses;
  for (const VertTriangle& t : vertTriangles(scene))
    for (int i = 0; t.hasArea() && i < 3; i++) uses[std::minmax(t.vertices[i], t.vertices[(i + 1) % 3])]++;
  return uses;
}

// Rays from inside a chamber, most of them to points near the ring, must hit. GRID may have cracks there, but must hit
// nearly as often: otherwise the compressed surface would be hit where there is none.
void expectNoMisses(const Twins& twins) {
  Random random(113);
  size_t missesOfGrid = 0;
  for (int i = 0; i < 400; i++) {
    const double a = 2 * M_PI * random.uniform(), r = random.uniform(0.6, 1),
                 height = i % 4 ? 0.1 * random.normal() : random.uniform(-1, 1);
    const Vec o = {float(random.uniform(-0.05, 0.05)), float(random.uniform(-0.05, 0.05)), i % 2 ? 0.2f : -0.2f};
    const RTCRayHit ray =
        makeRay(o, {float(r * std::cos(a)) - o[0], float(r * std::sin(a)) - o[1], float(height) - o[2]});
    missesOfGrid += !isHit(intersect(twins.grid, ray));
    ASSERT_TRUE(isHit(intersect(twins.scene, ray))) << "ray " << i;
    ASSERT_TRUE(occluded(twins.scene, ray)) << "ray " << i;
  }
  EXPECT_LE(missesOfGrid, 20u);
}

std::vector<SurfaceSettings> settingsWithLowRates(RTCCompression compression, const Cage& cage,
                                                  Displacement& displacement) {
  std::vector<SurfaceSettings> all;
  for (float rate : {1.0f, 2.0f, 3.0f, 7.0f}) all.push_back(sharedBorders(compression, rate));
  Random random(114);
  for (unsigned most : {2, 3, 9}) { // different rates on both sides of an edge
    all.push_back(sharedBorders(compression, 1));
    for (size_t i = 0; i < cage.indices.size(); i++) all.back().edgeRates.push_back(float(1 + random.below(most)));
  }
  for (SurfaceSettings& settings : all) settings.displacement = &displacement;
  return all;
}

std::string describe(const Chambers& c, const SurfaceSettings& settings) {
  const auto form = [](bool isPrism) { return isPrism ? "prism" : "pyramid"; };
  std::string rates = std::to_string(int(settings.rate));
  if (!settings.edgeRates.empty()) rates = testing::PrintToString(settings.edgeRates);
  return "ring of " + std::to_string(c.n) + (c.hasWall ? " edges with" : " edges without") + " a wall, " +
         form(c.isPrism[0]) + " below, " + form(c.isPrism[1]) + " above, rates " + rates;
}

/* No edge may belong to only one triangle. Along an edge of three faces, all use the vertices of the face with the
 * fewest quads there. */
TEST_P(CageTopology, ThreeFacesOnAnEdgeShareVertices) {
  Device device;
  Displacement displacement;
  for (const Chambers& c : chambers(true)) {
    const Cage cage = c.cage();
    for (const SurfaceSettings& settings : settingsWithLowRates(GetParam(), cage, displacement)) {
      SCOPED_TRACE(describe(c, settings));
      const Twins twins(device, cage, settings);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      expectNoMisses(twins);
      if (HasFatalFailure()) return;
      if (GetParam() != RTC_COMPRESSION_CVERT) continue;
      size_t open = 0, threefold = 0;
      for (const auto& edge : usesOfEdges(twins.scene)) {
        open += edge.second == 1;
        threefold += edge.second == 3;
      }
      EXPECT_EQ(open, 0u);
      EXPECT_EQ(threefold, quadsAlongRing(cage, c.n, settings));
    }
  }
}

TEST_P(CageTopology, TwoFacesOnAnEdgeShareVertices) {
  Device device;
  Displacement displacement;
  for (const Chambers& c : chambers(false)) {
    const Cage cage = c.cage();
    for (const SurfaceSettings& settings : settingsWithLowRates(GetParam(), cage, displacement)) {
      SCOPED_TRACE(describe(c, settings));
      const Twins twins(device, cage, settings);
      ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
      expectNoMisses(twins);
      if (HasFatalFailure()) return;
      if (GetParam() == RTC_COMPRESSION_CVERT) { EXPECT_EQ(countOpenEdges(vertTriangles(twins.scene)), 0u); }
    }
  }
}

// --- faces of opposite winding ---------------------------------------------------------

Cage boxWithReversedFaces(const std::vector<unsigned>& reversed, const Vec& size) {
  Cage cage = cubeCage();
  for (Vec& p : cage.positions)
    for (int k = 0; k < 3; k++) p[k] *= size[k];
  for (unsigned f : reversed) std::reverse(cage.indices.begin() + 4 * f, cage.indices.begin() + 4 * (f + 1));
  return cage;
}

/* Embree evaluates both faces at such an edge as if they ended there. Without displacement, and if the same faces are
 * reversed on both sides of the edge's ends, the borders have the same shape: they must be the same floats. */
TEST_P(CageTopology, FacesOfOppositeWindingShareVertices) {
  Device device;
  const std::vector<unsigned> sets[] = {{0}, {0, 2}, {0, 1}, {0, 1, 2, 3, 4}};
  for (const std::vector<unsigned>& reversed : sets)
    for (const Vec& size : {Vec{4, 1, 0.3f}, Vec{1, 1, 0.05f}, Vec{1, 7, 1}})
      for (float rate : {1.0f, 5.0f, 16.0f, -1.0f}) {
        SCOPED_TRACE(testing::Message() << reversed.size() << " faces, rate " << rate);
        const Cage cage = boxWithReversedFaces(reversed, size);
        SurfaceSettings settings = sharedBorders(GetParam(), std::max(rate, 1.0f));
        Random random(115);
        if (rate < 0)
          for (size_t i = 0; i < cage.indices.size(); i++) settings.edgeRates.push_back(float(1 + random.below(9)));
        Scene scene(device);
        addSurface(device, scene, cage, settings);
        rtcCommitScene(scene);
        ASSERT_EQ(device.takeError(), RTC_ERROR_NONE) << device.message;
        if (rate > 0) { // faces of different rates evaluate other vertices at their edge
          EXPECT_LE(statisticsOf(scene).maxBorderMismatch, 1e-6f * std::max({size[0], size[1], size[2]}));
        }
        for (int i = 0; i < 300; i++) {
          const RTCRayHit ray =
              makeRay({0, 0, 0}, {size[0] * float(random.uniform(-1, 1)), size[1] * float(random.uniform(-1, 1)),
                                  size[2] * float(random.uniform(-1, 1))});
          ASSERT_TRUE(isHit(intersect(scene, ray))) << "ray " << i;
        }
        if (GetParam() != RTC_COMPRESSION_CVERT) continue;
        for (const auto& edge : usesOfEdges(scene)) ASSERT_EQ(edge.second, 2u);
      }
}

// The faces with numbers 0 and 2 share an edge; only one of them is reversed. Displacement moves them apart.
TEST_P(CageTopology, DisplacedFacesOfOppositeWindingStayApart) {
  Device device;
  Displacement displacement;
  SurfaceSettings settings = sharedBorders(GetParam(), 8);
  settings.displacement = &displacement;
  const Twins twins(device, boxWithReversedFaces({0}, {1, 1, 1}), settings);
  Random random(116);
  size_t hits = 0;
  for (const RTCRayHit& ray : raysAt(random, 600)) {
    const RTCRayHit found = intersect(twins.scene, ray), expected = intersect(twins.grid, ray);
    if (!isHit(expected) || !isHit(found) || found.hit.primID != expected.hit.primID) continue;
    hits++;
    ASSERT_NEAR(found.ray.tfar, expected.ray.tfar, 0.1f);
  }
  EXPECT_GT(hits, 100u);
}

// One of the three faces has a vertex without a position. The other two have opposite or equal directions at the edge.
TEST_P(CageTopology, FacesOnAnEdgeShareVerticesIfAThirdIsLeftOut) {
  Device device;
  Displacement displacement;
  for (const bool isReversed : {false, true})
    for (const bool isDisplaced : {false, true}) {
      SCOPED_TRACE(testing::Message() << (isReversed ? "equal" : "opposite") << " directions"
                                      << (isDisplaced ? ", displaced" : ""));
      Cage cage;
      cage.positions = {{0, 0, 0},     {0, 0.7f, 0},  {3, 0, 0.1f}, {3, 1, 0},
                        {-0.2f, 0, 0}, {-0.2f, 1, 0}, {0, 0, NAN},  {0, 1, 1}};
      cage.addFace({0, 2, 3, 1});
      if (isReversed) cage.addFace({0, 4, 5, 1});
      else cage.addFace({1, 5, 4, 0});
      cage.addFace({0, 1, 7, 6});
      SurfaceSettings settings = sharedBorders(GetParam(), 16);
      if (isDisplaced) settings.displacement = &displacement;
      Scene scene(device);
      addSurface(device, scene, cage, settings);
      rtcCommitScene(scene);
      device.takeError();
      if (GetParam() != RTC_COMPRESSION_CVERT) continue;
      EXPECT_EQ(vertTriangles(scene).size(), 2u * 2 * 16 * 16);
      size_t open = 0;
      for (const auto& edge : usesOfEdges(scene)) open += edge.second == 1;
      EXPECT_EQ(open, 2u * 3 * 16) << "edges of the common border belong to two triangles";
    }
}

}} // namespace programs::test
