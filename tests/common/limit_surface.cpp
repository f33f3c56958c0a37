// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares OpenSubdiv's limit surface with formulas and with Embree's evaluation. */

#include "building/subdivision_geometry.h"
#include "scenes/cube.h"
#include "support/random_cages.h"
#include "surface/limit_surface.h"
#include "surface/topology_refiner.h"

#include <gtest/gtest.h>
#include <opensubdiv/far/primvarRefiner.h>

#include <map>
#include <tuple>

namespace programs::test { namespace {

/* Creases some of the edges, with equal sharpness. */
Cage creased(Cage cage, float sharpness, Random& random) {
  const FaceBorders borders(cage);
  for (unsigned face = 0; face < cage.numFaces(); face++)
    for (unsigned i = 0, n = cage.faceSizes[face]; i < n; i++) {
      const unsigned a = cage.faceIndices[borders.corner(face, i)],
                     b = cage.faceIndices[borders.corner(face, (i + 1) % n)];
      if (a < b && random.chance(0.3)) cage.creaseEdges.push_back({a, b});
    }
  cage.creaseSharpness.assign(cage.creaseEdges.size(), sharpness);
  return cage;
}

/* Creases the ring around the middle of a trapezohedron. */
Cage belted(Cage cage, float sharpness) {
  const unsigned n = unsigned(cage.numFaces());
  for (unsigned i = 0; i < n; i++) cage.creaseEdges.push_back({i, (i + 1) % n});
  cage.creaseSharpness.assign(n, sharpness);
  return cage;
}

/* --- formulas --------------------------------------------------------------------- */

TEST(LimitSurface, PlaneStaysAPlane) {
  Cage cage = sheet(5);
  for (Vec3f& p : cage.positions) p.z = 0.25f * p.x - 0.5f * p.y;
  const LimitSurface limit(cage);
  for (double u : {0.0, 0.3, 1.0})
    for (double v : {0.0, 0.75, 1.0}) {
      const LimitSample s = limit.evaluate({12, 0, u, v}); // the face in the center
      EXPECT_NEAR(s.p.x, 2 + u, 1e-12);
      EXPECT_NEAR(s.p.y, 2 + v, 1e-12);
      EXPECT_NEAR(s.p.z, 0.25 * s.p.x - 0.5 * s.p.y, 1e-12);
      EXPECT_NEAR(length(s.du - Vec3d{1, 0, 0.25}), 0, 1e-12);
      EXPECT_NEAR(length(s.duv), 0, 1e-12);
    }
}

/* Uniform cubic B-spline weights and their first two derivatives. */
void spline(double t, double w[3][4]) {
  const double s = 1 - t;
  const double values[3][4] = {
      {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6},
      {-s * s / 2, (3 * t * t - 4 * t) / 2, (-3 * s * s + 4 * s) / 2, t * t / 2},
      {s, 3 * t - 2, 3 * s - 2, t}};
  std::copy(&values[0][0], &values[0][0] + 12, &w[0][0]);
}

TEST(LimitSurface, RegularPatchesAreBicubicSplines) {
  Random random(1);
  const Cage cage = moved(sheet(3), random, 0.4);
  const LimitSurface limit(cage);
  for (int i = 0; i < 100; i++) {
    const double u = random.uniform(), v = random.uniform();
    double wu[3][4], wv[3][4];
    spline(u, wu);
    spline(v, wv);
    const LimitSample s = limit.evaluate({4, 0, u, v});
    const auto expect = [&](Vec3d found, int du, int dv) {
      Vec3d sum;
      for (int y = 0; y < 4; y++)
        for (int x = 0; x < 4; x++) sum += wu[du][x] * wv[dv][y] * toDouble(cage.positions[size_t(4 * y + x)]);
      EXPECT_NEAR(length(found - sum), 0, 1e-12) << "derivatives " << du << ", " << dv << " at " << u << ", " << v;
    };
    expect(s.p, 0, 0);
    expect(s.du, 1, 0);
    expect(s.dv, 0, 1);
    expect(s.duu, 2, 0);
    expect(s.duv, 1, 1);
    expect(s.dvv, 0, 2);
  }
}

TEST(LimitSurface, CubeCornersConvergeToOneHalf) {
  /* (n^2 v + 4 sum of neighbors + sum of vertices opposite in the faces) / (n (n + 5)) */
  const LimitSample s = LimitSurface(makeCube().cage).evaluate({5, 0, 1, 1});
  EXPECT_NEAR(length(s.p - Vec3d{0.5, 0.5, 0.5}), 0, 1e-12);
}

TEST(LimitSurface, VerticesOfAnyValenceHaveTheKnownLimit) {
  Random random(2);
  for (unsigned n = 3; n <= 10; n++) {
    const Cage cage = moved(trapezohedron(n), random, 0.2);
    const LimitSurface limit(cage);
    Vec3d neighbours, across;
    for (unsigned i = 0; i < n; i++) {
      neighbours += toDouble(cage.positions[2 * i]);
      across += toDouble(cage.positions[2 * i + 1]);
    }
    const Vec3d expected =
        (double(n * n) * toDouble(cage.positions[2 * n]) + 4.0 * neighbours + across) * (1.0 / (n * (n + 5.0)));
    for (unsigned face = 0; face < 2 * n; face += 2)
      EXPECT_NEAR(length(limit.evaluate({face, 0, 0, 0}).p - expected), 0, 1e-7) << "valence " << n;
  }
}

TEST(LimitSurface, DerivativesMatchPositions) {
  Random random(3);
  for (const Cage& cage : {moved(prism(5), random, 0.2), moved(trapezohedron(7), random, 0.2)}) {
    const Model model = modelOf(cage);
    const TrueSurface surface(model);
    const LimitSurface limit(cage);
    constexpr double h = 1e-6;
    for (int i = 0; i < 200; i++) {
      PatchPoint p = randomPoint(cage, surface, random);
      p.u = 0.1 + 0.8 * p.u; // away from corners, where second derivatives have no limit
      p.v = 0.1 + 0.8 * p.v;
      const LimitSample s = limit.evaluate(p);
      const auto at = [&](double du, double dv) { return limit.evaluate({p.face, p.subPatch, p.u + du, p.v + dv}); };
      const double k = 1 / (2 * h);
      EXPECT_NEAR(length((at(h, 0).p - at(-h, 0).p) * k - s.du), 0, 1e-7);
      EXPECT_NEAR(length((at(0, h).p - at(0, -h).p) * k - s.dv), 0, 1e-7);
      EXPECT_NEAR(length((at(h, 0).du - at(-h, 0).du) * k - s.duu), 0, 1e-4);
      EXPECT_NEAR(length((at(0, h).du - at(0, -h).du) * k - s.duv), 0, 1e-4);
      EXPECT_NEAR(length((at(0, h).dv - at(0, -h).dv) * k - s.dvv), 0, 1e-4);
    }
  }
}

/* --- Embree ------------------------------------------------------------------------ */

struct Deviation {
  double position = 0, angle = 0;
};

/* margin: distance of points from the borders of their patch. */
Deviation deviationFromEmbree(const Cage& cage, double margin, Random& random) {
  const Model model = modelOf(cage);
  const TrueSurface surface(model);
  const LimitSurface limit(cage);
  EmbreeDevice device("threads=1");
  const SceneHandle scene(rtcNewScene(device.handle()));
  DisplacementContext context;
  context.level = 2;
  const GeometryHandle geometry = SharedTopology(device, cage).makeGeometry(Placement(), context);
  rtcAttachGeometry(scene.get(), geometry.get());
  rtcCommitScene(scene.get());
  Deviation most;
  for (int i = 0; i < 2000; i++) {
    PatchPoint p = randomPoint(cage, surface, random);
    p.u = margin + (1 - 2 * margin) * p.u;
    p.v = margin + (1 - 2 * margin) * p.v;
    const FacePoint q = surface.patches().toEmbree(p);
    alignas(16) float P[4], du[4], dv[4];
    rtcInterpolate1(geometry.get(), q.face, q.u, q.v, RTC_BUFFER_TYPE_VERTEX, 0, P, du, dv, 3);
    const LimitSample s = limit.evaluate(p);
    const Vec3d m = normalize(cross(s.du, s.dv));
    const Vec3d n = normalize(cross(Vec3d{du[0], du[1], du[2]}, Vec3d{dv[0], dv[1], dv[2]}));
    most.position = std::max(most.position, length(Vec3d{P[0], P[1], P[2]} - s.p));
    most.angle = std::max(most.angle, std::atan2(length(cross(n, m)), dot(n, m)));
  }
  return most;
}

/* Some ulps of coordinates up to 4. Near extraordinary vertices Embree's tangents are differences over 2^-10 of a face,
 * which multiplies them by 2^10. */
constexpr double ulp = 0x1p-23, positionBound = 4 * 4 * ulp, angleBound = 4 * ulp * 0x1p10;

void expectEmbrees(const Cage& cage, double margin, Random& random) {
  const Deviation d = deviationFromEmbree(cage, margin, random);
  EXPECT_LT(d.position, positionBound) << cage.name << " of " << cage.numFaces() << " faces";
  EXPECT_LT(d.angle, angleBound) << cage.name << " of " << cage.numFaces() << " faces";
}

TEST(LimitSurface, MatchesEmbreeOnSmoothCages) {
  Random random(4);
  expectEmbrees(makeCube().cage, 0, random);
  for (unsigned n = 3; n <= 10; n++) {
    expectEmbrees(moved(trapezohedron(n), random, 0.1), 0, random);
    expectEmbrees(moved(prism(n), random, 0.1), 0, random);
  }
}

/* A sphere of triangles at the poles, and quads between three circles of latitude. */
Cage globe(unsigned meridians) {
  Cage cage;
  cage.name = "globe";
  for (unsigned circle = 1; circle <= 3; circle++)
    for (unsigned i = 0; i < meridians; i++) {
      const double latitude = M_PI * circle / 4, longitude = 2 * M_PI * i / meridians;
      cage.positions.push_back({float(std::sin(latitude) * std::cos(longitude)),
                                float(std::sin(latitude) * std::sin(longitude)), float(std::cos(latitude))});
    }
  cage.positions.push_back({0, 0, 1});
  cage.positions.push_back({0, 0, -1});
  const unsigned north = 3 * meridians, south = north + 1;
  for (unsigned i = 0; i < meridians; i++) {
    const unsigned next = (i + 1) % meridians, last = 2 * meridians;
    cage.faceSizes.insert(cage.faceSizes.end(), {3, 4, 4, 3});
    cage.faceIndices.insert(cage.faceIndices.end(), {north, i, next});
    for (unsigned from : {0u, meridians})
      cage.faceIndices.insert(cage.faceIndices.end(),
                              {from + i, from + meridians + i, from + meridians + next, from + next});
    cage.faceIndices.insert(cage.faceIndices.end(), {south, last + next, last + i});
  }
  return cage;
}

/* Stock Embree leaves out the faces at vertices of more than 64. Near the poles, faces are so narrow that some ulps
 * turn their normals. */
TEST(LimitSurface, MatchesEmbreeAtVerticesOfManyFaces) {
  Random random(10);
  for (unsigned n : {65u, 72u, 128u, 360u})
    for (const Cage& cage : {moved(trapezohedron(n), random, 0.01), moved(globe(n), random, 0.01)}) {
      EXPECT_LT(deviationFromEmbree(cage, 0, random).position, positionBound) << cage.name << " of " << n;
      if (n <= 128) expectEmbrees(cage, 0.125, random);
    }
}

TEST(LimitSurface, MatchesEmbreeOnOpenSheetsWithHoles) {
  Random random(5);
  Cage cage = moved(sheet(4), random, 0.3);
  for (BoundaryRule rule : {BoundaryRule::EdgeAndCorner, BoundaryRule::None}) {
    cage.boundary = rule;
    expectEmbrees(cage, 0, random);
  }
  cage.boundary = BoundaryRule::EdgeAndCorner;
  cage.holes = {5};
  expectEmbrees(cage, 0, random);
  cage.boundary = BoundaryRule::EdgeOnly; // except for corner faces
  cage.holes = {0, 3, 12, 15};
  cage.cornerVertices = {1, 3, 5, 9, 15, 19, 21, 23};
  cage.cornerSharpness.assign(8, INFINITY);
  expectEmbrees(cage, 0, random);
}

/* OpenSubdiv 3.5 crashes at the creases of a face that is wrapped around a vertex of another one. */
TEST(LimitSurface, CreasesOfWrappedFacesAreLeftOut) {
  Cage cage;
  cage.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0.2f}, {0, 1, 0}, {2, 0, 0}, {2, 1, 0}};
  cage.faceSizes = {4, 4, 3, 3};
  cage.faceIndices = {1, 4, 5, 2, 0, 1, 2, 3, 3, 2, 1, 0, 1, 2};
  cage.creaseEdges = {{1, 2}};
  cage.creaseSharpness = {3};
  cage.holes = {0, 3}; // otherwise three faces share an edge of the quad and the triangle
  testing::internal::CaptureStdout();
  const LimitSurface limit(cage);
  for (unsigned face = 0; face < 4; face++)
    EXPECT_TRUE(!limit.has(face) || std::isfinite(limit.evaluate({face, 0, 0.3, 0.6}).p.x)) << face;
  cage.creaseSharpness = {0};
  EXPECT_TRUE(LimitSurface(cage).has(1)) << "without a crease";
  cage.holes = {1, 2, 3};
  cage.creaseEdges = {{0, 3}};
  cage.creaseSharpness = {3};
  EXPECT_TRUE(LimitSurface(cage).has(0));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
}

/* Farthest distance between two limit surfaces, of faces that both have. */
double distanceOf(const Cage& a, const Cage& b) {
  const LimitSurface one(a), other(b);
  double most = 0;
  for (unsigned face = 0; face < a.numFaces(); face++)
    for (int i = 0; i <= 32; i++)
      for (int j = 0; j <= 32 && one.has(face) && other.has(face); j++) {
        const PatchPoint p{face, 0, i / 32.0, j / 32.0};
        most = std::max(most, length(one.evaluate(p).p - other.evaluate(p).p));
      }
  return most;
}

void addCreases(Cage& cage, unsigned face) {
  for (unsigned i = 0; i < 4; i++)
    cage.creaseEdges.push_back({cage.faceIndices[4 * face + i], cage.faceIndices[4 * face + (i + 1) % 4]});
  cage.creaseSharpness.assign(cage.creaseEdges.size(), INFINITY);
}

/* The figures of docs/error.md. OpenSubdiv evaluates the other faces as if a hole were one of them; Embree, and
 * LimitSurface, as if it did not exist. Edges have length 1. */
TEST(LimitSurface, HolesDifferFromOpenSubdivUnlessTheirBorderIsCreased) {
  Cage cube = makeCube().cage;
  for (Vec3f& p : cube.positions) p = 0.5f * p;
  for (const auto& [cage, hole, expected] : {std::tuple(sheet(4), 5u, 0.2353), {cube, 1u, 0.2763}}) {
    Cage holed = cage;
    holed.holes = {hole};
    EXPECT_NEAR(distanceOf(cage, holed), expected, 0.002) << cage.name;
    Random random(10);
    holed.boundary = BoundaryRule::EdgeAndCorner;
    expectEmbrees(holed, 0x1p-8, random);
    Cage creased = cage;
    creased.boundary = BoundaryRule::EdgeAndCorner;
    addCreases(creased, hole);
    holed = creased;
    holed.holes = {hole};
    EXPECT_LT(distanceOf(creased, holed), 1e-3) << cage.name;
  }
}

TEST(LimitSurface, CornerFacesOfOpenSheetsDifferFromEmbreeUnderTheDefaultRule) {
  Random random(11);
  Cage cage = sheet(3);
  const double flat = deviationFromEmbree(cage, 0, random).position;
  EXPECT_GT(flat, 0.005);
  EXPECT_LT(flat, 0.008);
  cage.boundary = BoundaryRule::EdgeAndCorner;
  expectEmbrees(cage, 0, random);
}

/* Two cubes with edges of length 1. shared: pairs of vertices, of the first and of the second cube, that are one. */
Cage twoCubes(const std::map<unsigned, unsigned>& shared) {
  const Cage cube = makeCube().cage;
  Cage cage = cube;
  const size_t first = shared.begin()->first, second = shared.begin()->second;
  std::vector<unsigned> number;
  for (unsigned v = 0; v < cube.positions.size(); v++) {
    const auto found = std::find_if(shared.begin(), shared.end(), [&](const auto& pair) { return pair.second == v; });
    number.push_back(found == shared.end() ? unsigned(cage.positions.size()) : found->first);
    if (found == shared.end())
      cage.positions.push_back(cube.positions[v] - cube.positions[second] + cube.positions[first]);
  }
  for (Vec3f& p : cage.positions) p = 0.5f * p;
  cage.faceSizes.insert(cage.faceSizes.end(), cube.faceSizes.begin(), cube.faceSizes.end());
  for (unsigned v : cube.faceIndices) cage.faceIndices.push_back(number[v]);
  return cage;
}

TEST(LimitSurface, CagesThatAreNotManifoldDifferFromEmbree) {
  const std::vector<Vec3f> p = makeCube().cage.positions;
  const auto at = [&](float x, float y, float z) {
    return unsigned(
        std::find_if(p.begin(), p.end(), [&](Vec3f q) { return q.x * x > 0 && q.y * y > 0 && q.z * z > 0; }) -
        p.begin());
  };
  Random random(12);
  const Cage edge = twoCubes({{at(1, 1, -1), at(-1, -1, -1)}, {at(1, 1, 1), at(-1, -1, 1)}});
  const Cage vertex = twoCubes({{at(1, 1, 1), at(-1, -1, -1)}});
  EXPECT_NEAR(deviationFromEmbree(edge, 0x1p-8, random).position, 0.156, 0.02);
  const double atVertex = deviationFromEmbree(vertex, 0x1p-8, random).position; // 0.43 at the vertex itself
  EXPECT_GT(atVertex, 0.25);
  EXPECT_LT(atVertex, 0.44);
}

TEST(LimitSurface, HolesKeepTheCreaseRule) {
  Random random(6);
  Cage cage = moved(sheet(4), random, 0.3);
  cage.creaseEdges = {{6, 7}, {7, 8}};
  cage.creaseSharpness = {0.5f, 2.5f};
  Cage uniform = cage;
  cage.creaseRule = CreaseRule::Chaikin;
  Cage holed = cage;
  holed.holes = {15};
  const PatchPoint nearCrease{6, 0, 0.2, 0.05}; // right of vertex 7, where the creases meet
  const Vec3d p = LimitSurface(cage).evaluate(nearCrease).p;
  EXPECT_NEAR(length(LimitSurface(holed).evaluate(nearCrease).p - p), 0, 1e-12);
  EXPECT_GT(length(LimitSurface(uniform).evaluate(nearCrease).p - p), 1e-4);
}

/* Faces with these numbers of vertices around vertex 0, open, over five sixths of a circle. */
Cage fan(const std::vector<unsigned>& faceSizes) {
  Cage cage;
  cage.name = "fan";
  cage.boundary = BoundaryRule::EdgeAndCorner;
  const double step = 10 * M_PI / 6 / double(faceSizes.size());
  const auto addVertex = [&](double angle, double radius) {
    cage.positions.push_back(
        {float(radius * std::cos(angle)), float(radius * std::sin(angle)), float(0.1 * std::cos(3 * angle))});
    return unsigned(cage.positions.size() - 1);
  };
  cage.positions.push_back({0, 0, 0.3f});
  unsigned spoke = addVertex(0, 1);
  for (size_t face = 0; face < faceSizes.size(); face++) {
    cage.faceSizes.push_back(faceSizes[face]);
    cage.faceIndices.insert(cage.faceIndices.end(), {0, spoke});
    for (unsigned i = 1; i + 2 < faceSizes[face]; i++)
      cage.faceIndices.push_back(addVertex((double(face) + i / double(faceSizes[face] - 2)) * step, 1.1));
    spoke = addVertex(double(face + 1) * step, 1);
    cage.faceIndices.push_back(spoke);
  }
  return cage;
}

/* Quads, and in their middle one face with this number of vertices. A ring has n - 2 vertices per face of n vertices,
 * and two between the borders. Stock Embree supports at most 128. */
TEST(LimitSurface, MatchesEmbreeAtTheLongestRings) {
  Random random(9);
  for (const auto& [quads, other] :
       {std::pair(62u, 4u), {62u, 5u}, {61u, 7u}, {60u, 9u}, {53u, 16u}, {64u, 4u}, {200u, 16u}}) {
    std::vector<unsigned> faceSizes(quads, 4);
    faceSizes.insert(faceSizes.begin() + quads / 2, other);
    expectEmbrees(fan(faceSizes), 0, random);
  }
}

/* Away from borders of patches: along infinitely sharp creases both sides close the last 2^-10 of a face differently.
 * */
TEST(LimitSurface, MatchesEmbreeWithCreasesAndCorners) {
  Random random(6);
  constexpr double margin = 0x1p-8;
  for (unsigned n = 3; n <= 10; n++) {
    const Cage t = moved(trapezohedron(n), random, 0.1), p = moved(prism(n), random, 0.1);
    for (float sharpness : {1.0f, 2.0f, INFINITY}) {
      expectEmbrees(creased(t, sharpness, random), margin, random);
      expectEmbrees(creased(p, sharpness, random), margin, random);
    }
    for (float sharpness : {0.4f, 1.7f, 2.5f}) {
      expectEmbrees(belted(t, sharpness), margin, random);
      Cage cornered = t;
      cornered.cornerVertices = {0, n + 1};
      cornered.cornerSharpness = {sharpness, INFINITY};
      expectEmbrees(cornered, margin, random);
    }
  }
}

/* OpenSubdiv's shapes catmark_cube_creases1 and 2. last: sharpness of the crease from vertex 3 to 5. */
Cage creasedCube(float sharpness, float last) {
  Cage cage;
  cage.name = "creased cube";
  const float a = 1.414214f;
  cage.positions = {{0, -a, 1}, {a, 0, 1}, {-a, 0, 1}, {0, a, 1}, {-a, 0, -1}, {0, a, -1}, {0, -a, -1}, {a, 0, -1}};
  cage.faceSizes.assign(6, 4);
  cage.faceIndices = {0, 1, 3, 2, 2, 3, 5, 4, 4, 5, 7, 6, 6, 7, 1, 0, 1, 7, 5, 3, 6, 0, 2, 4};
  cage.creaseEdges = {{0, 1}, {1, 3}, {3, 2}, {2, 0}, {4, 5}, {5, 7}, {7, 6}, {6, 4}, {0, 6}, {1, 7}, {2, 4}, {3, 5}};
  cage.creaseSharpness.assign(12, sharpness);
  cage.creaseSharpness.back() = last;
  return cage;
}

constexpr unsigned fadingVertex = 3;          // a vertex of the creased cube
constexpr PatchPoint fadingPoint{0, 0, 1, 1}; // its position in face 0

/* After one step of OpenSubdiv's subdivision, with the remaining sharpness. */
Cage refined(const Cage& cage) {
  namespace Far = OpenSubdiv::Far;
  struct Point {
    Vec3f p;
    void Clear() { p = {}; }
    void AddWithWeight(const Point& q, float weight) { p += weight * q.p; }
  };
  const std::unique_ptr<Far::TopologyRefiner> refiner = makeTopologyRefiner(cage, true);
  Far::TopologyRefiner::UniformOptions options(1);
  options.fullTopologyInLastLevel = true;
  refiner->RefineUniform(options);
  const Far::TopologyLevel level = refiner->GetLevel(1);
  std::vector<Point> from, to(size_t(level.GetNumVertices()));
  for (const Vec3f& p : cage.positions) from.push_back({p});
  Far::PrimvarRefiner(*refiner).Interpolate(1, from, to);
  Cage result;
  result.name = cage.name + ", refined";
  for (const Point& point : to) result.positions.push_back(point.p);
  for (int face = 0; face < level.GetNumFaces(); face++) {
    const Far::ConstIndexArray vertices = level.GetFaceVertices(face);
    result.faceSizes.push_back(unsigned(vertices.size()));
    result.faceIndices.insert(result.faceIndices.end(), vertices.begin(), vertices.end());
  }
  for (int edge = 0; edge < level.GetNumEdges(); edge++)
    if (const float sharpness = level.GetEdgeSharpness(edge); sharpness > 0.0f) {
      const Far::ConstIndexArray vertices = level.GetEdgeVertices(edge);
      result.creaseEdges.push_back({unsigned(vertices[0]), unsigned(vertices[1])});
      result.creaseSharpness.push_back(sharpness >= 10.0f ? INFINITY : sharpness);
    }
  return result;
}

/* The first step at vertex 3 computed by hand: 0.1 of the corner, which stays, and 0.9 of the crease through it.
 * OpenSubdiv's regression baseline of Hbr also has 1.09601581. */
TEST(LimitSurface, FadingCreaseIsBlendedAsInThePaper) {
  const Cage cage = creasedCube(5.0f, 0.1f);
  const float corner = cage.positions[fadingVertex].y, crease = 6.0f / 8.0f * corner;
  const float expected = 0.1f * corner + 0.9f * crease;
  EXPECT_NEAR(expected, 1.09601581f, 1e-6f);
  const std::vector<Vec3f> after = refined(cage).positions;
  const auto found = std::find_if(after.begin(), after.end(), [&](Vec3f p) {
    return p.x == 0.0f && p.z == 1.0f && std::abs(p.y - expected) < 1e-6f;
  });
  EXPECT_NE(found, after.end());
}

TEST(LimitSurface, IsContinuousInTheSharpnessOfAThirdCreaseUnlikeEmbree) {
  const auto reach = [](float last) { return LimitSurface(creasedCube(INFINITY, last)).evaluate(fadingPoint).p.y; };
  EXPECT_NEAR(reach(0.001f), reach(0.0f), 0.001);
  EXPECT_GT(reach(0.5f), reach(0.001f) + 0.1);

  Random random(7);
  expectEmbrees(creasedCube(INFINITY, 0.0f), 0x1p-8, random);
  EXPECT_GT(deviationFromEmbree(creasedCube(INFINITY, 0.001f), 0x1p-8, random).position, 0.1);
}

/* After the fading crease is gone, both use the same rules. */
TEST(LimitSurface, MatchesEmbreeAfterOneStepOfOpenSubdiv) {
  Random random(8);
  for (float sharpness : {5.0f, INFINITY}) {
    const Cage cage = creasedCube(sharpness, 0.1f), child = refined(cage);
    EXPECT_GT(deviationFromEmbree(cage, 0x1p-8, random).position, 0.1) << sharpness;
    expectEmbrees(child, 0x1p-8, random);
    const Vec3d whole = LimitSurface(cage).evaluate({0, 0, 0.75, 0.75}).p;
    const Vec3d part = LimitSurface(child).evaluate({2, 0, 0.5, 0.5}).p; // of the quarter at the third corner
    EXPECT_NEAR(length(whole - part), 0.0, 1e-6) << sharpness;
  }
}

}} // namespace programs::test
