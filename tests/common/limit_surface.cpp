// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Compares OpenSubdiv's limit surface with Embree's evaluation. */

#include "building/subdivision_geometry.h"
#include "scenes/cube.h"
#include "support/random_cages.h"
#include "surface/limit_surface.h"

#include <gtest/gtest.h>

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

/* The figures of docs/accuracy.md. OpenSubdiv evaluates the other faces as if a hole were one of them; Embree, and
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

}} // namespace programs::test
