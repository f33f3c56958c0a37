// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Hard cases: the longest rings around a vertex, and faces without edges. GRID is tested as well, because these limits
 * are Embree's. */

#include "hard_cases/hard_case.h"
#include "support/grid_agreement.h"

#include <set>

namespace programs::test { namespace {

/* Faces around vertex 0 with these numbers of vertices; open, over five sixths of a circle. */
Cage fanCage(const std::vector<unsigned>& sizes) {
  Cage cage;
  const double step = 10 * M_PI / 6 / double(sizes.size());
  auto addVertex = [&](double angle, double radius) {
    cage.positions.push_back(
        {float(radius * std::cos(angle)), float(radius * std::sin(angle)), float(0.1 * std::cos(3 * angle))});
    return unsigned(cage.positions.size() - 1);
  };
  cage.positions.push_back({0, 0, 0.3f});
  unsigned spoke = addVertex(0, 1);
  for (size_t face = 0; face < sizes.size(); face++) {
    cage.faces.push_back(sizes[face]);
    cage.indices.insert(cage.indices.end(), {0, spoke});
    for (unsigned i = 1; i + 2 < sizes[face]; i++)
      cage.indices.push_back(addVertex((double(face) + i / double(sizes[face] - 2)) * step, 1.1));
    spoke = addVertex(double(face + 1) * step, 1);
    cage.indices.push_back(spoke);
  }
  return cage;
}

Cage fanCage(unsigned quads, std::initializer_list<unsigned> others) {
  std::vector<unsigned> sizes(quads, 4);
  sizes.insert(sizes.begin() + quads / 2, others);
  return fanCage(sizes);
}

// The faces of all intersections of the rays that use this context.
struct PassedFaces : RTCIntersectContext {
  PassedFaces() {
    rtcInitIntersectContext(this);
    filter = take;
  }
  std::set<unsigned> faces;

private:
  static void take(const RTCFilterFunctionNArguments* args) {
    for (unsigned i = 0; i < args->N; i++)
      if (args->valid[i]) {
        ((PassedFaces*)args->context)->faces.insert(RTCHitN_primID(args->hit, args->N, i));
        args->valid[i] = 0;
      }
  }
};

// A scene with one surface that allows filters.
class FilteredScene : public Scene {
public:
  FilteredScene(RTCDevice device, const Cage& cage, const SurfaceSettings& settings)
    : Scene(device, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION) {
    addSurface(device, *this, cage, settings);
    rtcCommitScene(*this);
  }
};

std::set<unsigned> facesBelow(RTCScene scene, const std::vector<Vec>& points) {
  PassedFaces passed;
  for (const Vec& p : points) {
    RTCRayHit ray = makeRay({p[0], p[1], 2}, {0, 0, -1});
    rtcIntersect1(scene, &passed, &ray);
  }
  return passed.faces;
}

class CageLimits : public HardCase {
protected:
  SurfaceSettings settings(RTCCompression kind) {
    SurfaceSettings s;
    s.rate = 8;
    s.compression = kind;
    s.displacement = &displacement;
    return s;
  }
  std::vector<RTCCompression> withGrid() const { return {RTC_COMPRESSION_NONE, compression()}; }

private:
  Displacement displacement = {0.02f, 4};
};
INSTANTIATE_TEST_SUITE_P(HardCases, CageLimits, testing::ValuesIn(tracers()), tracerName);

// Sizes of a ring: two vertices per quad, one more per pentagon, two for the gap between the borders; 1024 faces
// including the gap. Rings of up to 64 faces are in Embree's own limits.
TEST_P(CageLimits, LongestRingsOfBorderVertices) {
  property(
      "a border vertex of 62 quads and a pentagon, and of up to 152 faces, has all its faces, and hits on them agree "
      "with GRID's");
  for (const Cage& cage : {fanCage(62, {5}), fanCage(61, {7}), fanCage(60, {9}), fanCage(53, {16}), fanCage(62, {}),
                           fanCage(63, {}), fanCage(39, {5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5, 5}),
                           fanCage(64, {}), fanCage(63, {5}), fanCage(40, {16, 16, 16, 16}), fanCage(150, {5, 16})}) {
    SCOPED_TRACE(testing::Message() << cage.faces.size() << " faces, " << cage.indices.size() << " corners");
    std::vector<Vec> circle;
    for (int i = 1; i < 4000; i++)
      circle.push_back({float(0.7 * std::cos(i * 10 * M_PI / 24000)), float(0.7 * std::sin(i * 10 * M_PI / 24000)), 0});
    for (RTCCompression kind : withGrid())
      ASSERT_EQ(facesBelow(FilteredScene(device, cage, settings(kind)), circle).size(), cage.faces.size())
          << kindName(kind);
    const bool isPastEmbrees = cage.faces.size() > 63 || cage.indices.size() > 64 * 4; // frames do not fit its needles
    if (isPastEmbrees && compression() != RTC_COMPRESSION_CVERT) continue;
    const Twins twins(device, cage, settings(compression()));
    Random random(61);
    const std::vector<RTCRayHit> rays = raysAt(random, 800);
    if (compression() == RTC_COMPRESSION_CGRID) expectEqualToGrid(twins.grid, twins.scene, rays, cage);
    else expectCloseToGrid(twins.grid, twins.scene, rays, cage, settings(compression()));
    if (HasFatalFailure()) return;
  }
}

TEST_P(CageLimits, RingsPastTheLongest) {
  property(
      "faces at a vertex of more than 1024 faces, on a border more than 1023, or with a longer ring of vertices than "
      "rings store, are left out");
  for (const Cage& cage : {fanCage(1024, {}), fanCage(1025, {}), fanCage(1023, {5}), fanCage(1017, {16})}) {
    SCOPED_TRACE(testing::Message() << cage.faces.size() << " faces, " << cage.indices.size() << " corners");
    for (RTCCompression kind : withGrid()) {
      const SurfaceScene scene(device, cage, settings(kind));
      Random random(62);
      for (const RTCRayHit& ray : raysAt(random, 200)) ASSERT_FALSE(isHit(intersect(scene, ray)));
    }
  }
}

// A sheet of 3 x 3 quads with faces without edges before the faces `at`; 9 means after the last face.
struct Sheet {
  explicit Sheet(const std::multiset<unsigned>& at) {
    cage.faces.clear();
    for (unsigned face = 0; face <= 9; face++) {
      cage.faces.insert(cage.faces.end(), at.count(face), 0);
      if (face == 9) break;
      faces.insert(unsigned(cage.faces.size()));
      cage.faces.push_back(4);
    }
    for (int y = 0; y < 30; y++)
      for (int x = 0; x < 30; x++) points.push_back({float(x / 15. - 0.97), float(y / 15. - 0.97), 0});
  }
  Cage cage = sheetCage(3);
  std::set<unsigned> faces; // faces that have edges
  std::vector<Vec> points;
};

TEST_P(CageLimits, FacesWithoutEdges) {
  property("faces without edges, first, last or between others, have no surface, and all other faces have a surface");
  for (RTCSubdivisionMode mode : {RTC_SUBDIVISION_MODE_SMOOTH_BOUNDARY, RTC_SUBDIVISION_MODE_NO_BOUNDARY})
    for (const std::multiset<unsigned>& at : {std::multiset<unsigned>{9}, {0}, {4}, {0, 0, 4, 4, 5, 9, 9, 9}}) {
      SCOPED_TRACE(testing::Message() << at.size() << " without edges, the last before face " << *at.rbegin()
                                      << ", mode " << mode);
      Sheet sheet(at);
      sheet.cage.mode = mode;
      std::set<unsigned> expected = sheet.faces;
      if (mode == RTC_SUBDIVISION_MODE_NO_BOUNDARY) expected = {*std::next(sheet.faces.begin(), 4)};
      for (RTCCompression kind : withGrid()) {
        const FilteredScene scene(device, sheet.cage, settings(kind));
        ASSERT_EQ(facesBelow(scene, sheet.points), expected) << kindName(kind);
      }
    }
}

TEST_P(CageLimits, OnlyFacesWithoutEdges) {
  property("a cage in which no face has edges has no surface");
  Cage cage = quadCage();
  cage.faces = {0, 0, 0};
  for (RTCCompression kind : withGrid()) {
    const SurfaceScene scene(device, cage, settings(kind));
    ASSERT_FALSE(isHit(intersect(scene, makeRay({0.5f, 0.5f, 1}, {0, 0, -1}))));
  }
}

// The half-edges of the last face still exist after those in use.
TEST_P(CageLimits, FacesThatLoseTheirEdges) {
  property(
      "if the last face of a surface loses its edges and the surface is committed again, only the surface of that face "
      "disappears");
  for (RTCCompression kind : withGrid()) {
    Sheet sheet({});
    Scene scene(device, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    const RTCGeometry geometry = newSurface(device, sheet.cage, settings(kind));
    attach(scene, geometry);
    rtcCommitScene(scene);
    ASSERT_EQ(facesBelow(scene, sheet.points), sheet.faces) << kindName(kind);
    ((unsigned*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_FACE, 0))[8] = 0;
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_FACE, 0);
    rtcCommitGeometry(geometry);
    rtcCommitScene(scene);
    sheet.faces.erase(8);
    ASSERT_EQ(facesBelow(scene, sheet.points), sheet.faces) << kindName(kind);
  }
}

}} // namespace programs::test
