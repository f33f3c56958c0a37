// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Closest points equal those of a search through all stored triangles in double precision: cages with stitched edges
 * and holes, grids, regular and irregular meshes, moving ones, near and far, in every form and on every instruction
 * set. */

#include "small_cube.h"
#include "support/random.h"

#include <cbvh/cbvh.h>
#include <gtest/gtest.h>

#include <array>
#include <cfloat>
#include <cstring>
#include <memory>
#include <set>
#include <string>
#include <tuple>
#include <vector>

namespace programs::test { namespace {

typedef std::array<double, 3> Point;

Point operator-(const Point& a, const Point& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Point along(const Point& a, double t, const Point& b) { return {a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]}; }
double dot(const Point& a, const Point& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Point& a) { return std::sqrt(dot(a, a)); }

struct Triangle {
  Point a, b, c;
  unsigned geomID, primID;

  // By the regions of Ericson, Real-Time Collision Detection, section 5.1.5, unlike the library.
  double distance(const Point& p) const {
    const Point ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
    const double d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp), d5 = dot(ab, cp),
                 d6 = dot(ac, cp), va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    if (d1 <= 0 && d2 <= 0) return length(ap);
    if (d3 >= 0 && d4 <= d3) return length(bp);
    if (d6 >= 0 && d5 <= d6) return length(cp);
    if (vc <= 0 && d1 >= 0 && d3 <= 0) return length(along(a, d1 / (d1 - d3), ab) - p);
    if (vb <= 0 && d2 >= 0 && d6 <= 0) return length(along(a, d2 / (d2 - d6), ac) - p);
    if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
      return length(along(b, (d4 - d3) / ((d4 - d3) + (d5 - d6)), c - b) - p);
    return length(along(along(a, vb / (va + vb + vc), ab), vc / (va + vb + vc), ac) - p);
  }

  bool isFinite() const { return std::isfinite(dot(a, a) + dot(b, b) + dot(c, c)); }
  bool hasThreeVertices() const { return a != b && a != c && b != c; }
};

struct Context {
  CbvhContext handle = nullptr;
  explicit Context(const std::string& settings) { cbvhNewContext(settings.c_str(), nullptr, nullptr, &handle); }
  ~Context() { cbvhReleaseContext(handle); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
};

// Surfaces, and all of their triangles at a time.
struct Surfaces {
  std::vector<CbvhSurface> handles;
  CbvhGroup group = nullptr;

  Surfaces() = default;
  ~Surfaces() {
    cbvhReleaseGroup(group);
    for (CbvhSurface surface : handles) cbvhReleaseSurface(surface);
  }
  Surfaces(const Surfaces&) = delete;
  Surfaces& operator=(const Surfaces&) = delete;

  void commit(CbvhContext context) {
    ASSERT_EQ(cbvhNewGroup(context, handles.data(), handles.size(), &group), CBVH_OK);
    ASSERT_EQ(cbvhCommitGroup(group), CBVH_OK) << cbvhGetErrorText();
  }

  std::vector<Triangle> trianglesAt(float time) const {
    struct Collector {
      std::vector<Triangle> triangles;
      unsigned geomID = 0;
    } collector;
    for (CbvhSurface surface : handles) {
      const CbvhPartFunction add = [](void* self, const CbvhPart* part) {
        Collector& to = *(Collector*)self;
        auto vertex = [&](unsigned x, unsigned y) {
          const float* v = part->vertices + 3 * (y * part->width + x);
          return Point{v[0], v[1], v[2]};
        };
        for (unsigned y = 0; y + 1 < part->height; y++)
          for (unsigned x = 0; x + 1 < part->width; x++)
            for (unsigned i = 0; i < 2; i++) {
              const unsigned quad = y * (part->width - 1) + x, each = part->primitivesPerQuad,
                             primID = each ? part->primIDs[each * quad + (each == 2 ? i : 0)] : part->primID;
              const Triangle triangle = {i ? vertex(x, y + 1) : vertex(x, y), vertex(x + 1, y),
                                         i ? vertex(x + 1, y + 1) : vertex(x, y + 1), to.geomID, primID};
              if (triangle.isFinite() && triangle.hasThreeVertices()) to.triangles.push_back(triangle);
            }
        return 1;
      };
      EXPECT_EQ(cbvhForEachPart(surface, time, add, &collector), CBVH_OK) << cbvhGetErrorText();
      collector.geomID++;
    }
    return collector.triangles;
  }
};

// --- input ---

void displace(const CbvhDisplacementArguments* args) {
  for (unsigned i = 0; i < args->count; i++) {
    const float height = 0.05f * std::sin(9 * args->P_x[i] + 4 * float(args->timeStep)) * std::cos(7 * args->P_y[i]);
    args->P_x[i] += height * args->Ng_x[i];
    args->P_y[i] += height * args->Ng_y[i];
    args->P_z[i] += height * args->Ng_z[i];
  }
}

struct Input {
  const char* name;
  unsigned numSteps;
  bool isLossless;
};

class Builder {
public:
  Builder(Surfaces& surfaces, CbvhContext context, const Input& input)
    : surfaces(surfaces),
      context(context),
      input(input) {}

  void add() {
    const std::string name = input.name;
    if (name == "cage") addCage(8, nullptr);
    if (name == "stitched cage") {
      std::vector<float> rates;
      for (unsigned i = 0; i < 24; i++) {
        const unsigned a = cubeIndices[i], b = cubeIndices[i / 4 * 4 + (i + 1) % 4];
        rates.push_back(float(3 + 5 * (std::min(a, b) % 4) + std::max(a, b)));
      }
      addCage(1, rates.data());
    }
    if (name == "grids") addSheet(0, false);
    if (name == "quads") addSheet(4, false);
    if (name == "triangles") addSheet(3, false);
    if (name == "irregular triangles") addSheet(3, true);
    if (name == "several") {
      addCage(5, nullptr);
      addSheet(3, true);
      addSheet(0, false);
    }
  }

private:
  // A surface after its input was set.
  template<typename SetInput>
  void addSurface(const SetInput& setInput) {
    CbvhSurface surface = nullptr;
    ASSERT_EQ(cbvhNewSurface(context, &surface), CBVH_OK);
    surfaces.handles.push_back(surface);
    ASSERT_EQ(cbvhSetSurfaceLossless(surface, input.isLossless), CBVH_OK);
    ASSERT_EQ(setInput(surface), CBVH_OK) << cbvhGetErrorText();
    ASSERT_EQ(cbvhCommitSurface(surface, nullptr, nullptr), CBVH_OK) << cbvhGetErrorText();
  }

  void addCage(float rate, const float* rates) {
    CbvhCage cage = cube();
    std::vector<const float*> steps(input.numSteps, cubeVertices);
    cage.vertices.steps = steps.data();
    cage.vertices.numSteps = input.numSteps;
    cage.rate = rate;
    cage.rates = rates;
    cage.displacement = displace;
    const unsigned hole = 2;
    cage.numHoles = 1;
    cage.holes = &hole;
    addSurface([&](CbvhSurface surface) { return cbvhSetSurfaceCage(surface, &cage); });
  }

  // A sheet of 40 x 40 quads. corners: of faces; 0 for a grid.
  void addSheet(unsigned corners, bool isIrregular) {
    const unsigned side = 41;
    Random random(7);
    std::vector<std::vector<float>> vertices(input.numSteps);
    for (unsigned step = 0; step < input.numSteps; step++) {
      for (unsigned y = 0; y < side; y++)
        for (unsigned x = 0; x < side; x++) {
          const double u = x / (side - 1.0), v = y / (side - 1.0), jitter = isIrregular ? 0.3 / side : 0;
          vertices[step].push_back(float(3 * u - 1.5 + random.uniform(-jitter, jitter)));
          vertices[step].push_back(float(3 * v - 1.5 + random.uniform(-jitter, jitter)));
          vertices[step].push_back(float(1.5 + 0.4 * std::sin(7 * u + 0.6 * step) * std::cos(5 * v)));
        }
      if (!isIrregular) vertices[step][3 * (5 * side + 7)] = NAN;
      vertices[step].push_back(0); // padding
    }
    std::vector<const float*> steps;
    for (const auto& step : vertices) steps.push_back(step.data());
    const CbvhVertices vertexInput = {size_t(side) * side, 12, steps.data(), input.numSteps, 0, 1};
    if (corners == 0) {
      const CbvhGrid grid = {0, side, side, side};
      CbvhGrids grids = CbvhGrids();
      grids.numGrids = 1;
      grids.grids = &grid;
      grids.vertices = vertexInput;
      addSurface([&](CbvhSurface surface) { return cbvhSetSurfaceGrids(surface, &grids); });
      return;
    }
    std::vector<unsigned> indices;
    for (unsigned y = 0; y + 1 < side; y++)
      for (unsigned x = 0; x + 1 < side; x++) {
        const unsigned a = y * side + x, q[] = {a, a + 1, a + side + 1, a + side},
                       turn = isIrregular ? random.below(2) : 0;
        if (corners == 4) indices.insert(indices.end(), q, q + 4);
        else
          for (unsigned half : {0u, 2u})
            for (unsigned i = 0; i < 3; i++) indices.push_back(q[(i + half + turn) % 4]);
      }
    CbvhMesh mesh = CbvhMesh();
    mesh.verticesPerFace = corners;
    mesh.numFaces = indices.size() / corners;
    mesh.indices = indices.data();
    mesh.vertices = vertexInput;
    addSurface([&](CbvhSurface surface) { return cbvhSetSurfaceMesh(surface, &mesh); });
  }

  Surfaces& surfaces;
  const CbvhContext context;
  const Input& input;
};

// --- checks ---

CbvhPointQuery queryAt(const Point& p, float time, double radius) {
  CbvhPointQuery query = CbvhPointQuery();
  query.x = float(p[0]);
  query.y = float(p[1]);
  query.z = float(p[2]);
  query.time = time;
  query.radius = float(radius);
  return query;
}

Point pointOf(const CbvhPointQuery& query) { return {query.x, query.y, query.z}; }

// A point near the surface, in its bounds, far away, at a vertex, in an edge, or in a triangle.
Point randomPoint(Random& random, const std::vector<Triangle>& triangles) {
  const Triangle& t = triangles[random.below(unsigned(triangles.size()))];
  const Point inside = along(along(t.a, random.uniform(), t.b - t.a), random.uniform() / 2, t.c - t.a);
  auto around = [&](const Point& p, double size) {
    return Point{p[0] + size * random.normal(), p[1] + size * random.normal(), p[2] + size * random.normal()};
  };
  switch (random.below(6)) {
  case 0: return around(inside, 0.02);
  case 1: return around(inside, 0.7);
  case 2: return around(inside, random.magnitude(10, 1e4));
  case 3: return t.b;
  case 4: return along(t.a, random.uniform(), t.b - t.a);
  default: return inside;
  }
}

// Largest distance by which rounding of coordinates moves a point.
double roundingOf(const Point& p) { return 4 * FLT_EPSILON * (length(p) + 4); }

void expectClosest(const Surfaces& surfaces, const std::vector<Triangle>& triangles, const CbvhPointQuery& query,
                   CbvhClosestPoint& found) {
  const Point p = pointOf(query);
  double nearest = INFINITY;
  for (const Triangle& t : triangles) nearest = std::min(nearest, t.distance(p));
  ASSERT_EQ(cbvhPointQuery(surfaces.group, &query, &found), 1);
  const double tolerance = 2e-7 * nearest + 1e-14 * (length(p) + 4);
  ASSERT_NEAR(found.distance, nearest, tolerance);
  double ofPrimitive = INFINITY;
  for (const Triangle& t : triangles)
    if (t.geomID == found.geomID && t.primID == found.primID) ofPrimitive = std::min(ofPrimitive, t.distance(p));
  ASSERT_NEAR(ofPrimitive, nearest, tolerance) << "primitive " << found.primID << " of surface " << found.geomID;
  const Point at = {found.x, found.y, found.z};
  ASSERT_NEAR(length(at - p), nearest, roundingOf(at) + tolerance);

  CbvhClosestPoint reference;
  const float position[] = {query.x, query.y, query.z};
  ASSERT_LT(found.geomID, surfaces.handles.size());
  const CbvhSurface surface = surfaces.handles[found.geomID];
  ASSERT_EQ(cbvhFindClosestPoint(surface, query.time, found.primID, position, INFINITY, &reference), 1);
  ASSERT_EQ(reference.distance, found.distance);

  CbvhTriangle stored;
  ASSERT_EQ(cbvhFindTriangle(surface, query.time, found.primID, found.u, found.v, &found.Ng_x, &stored), 1);
  const double area = (stored.u[1] - stored.u[0]) * (double(stored.v[2]) - stored.v[0]) -
                      (stored.u[2] - stored.u[0]) * (double(stored.v[1]) - stored.v[0]),
               w1 = ((found.u - stored.u[0]) * (double(stored.v[2]) - stored.v[0]) -
                     (stored.u[2] - stored.u[0]) * (double(found.v) - stored.v[0])) /
                    area,
               w2 = ((stored.u[1] - stored.u[0]) * (double(found.v) - stored.v[0]) -
                     (found.u - stored.u[0]) * (double(stored.v[1]) - stored.v[0])) /
                    area;
  auto vertex = [&](int i) { return Point{stored.vertices[i][0], stored.vertices[i][1], stored.vertices[i][2]}; };
  const Point ab = vertex(1) - vertex(0), ac = vertex(2) - vertex(0);
  const Point byParameters = along(along(vertex(0), w1, ab), w2, ac);
  ASSERT_LE(length(byParameters - at), 2e-4 * (length(ab) + length(ac)) + roundingOf(at));
}

class ClosestPoints : public testing::TestWithParam<std::tuple<std::string, std::string>> {
protected:
  ClosestPoints() : context(std::get<0>(GetParam()) + "," + std::get<1>(GetParam())) {}

  void SetUp() override {
    if (!context.handle) GTEST_SKIP() << cbvhGetErrorText();
  }

  void build(Surfaces& surfaces, const Input& input) {
    Builder(surfaces, context.handle, input).add();
    surfaces.commit(context.handle);
  }

  Context context;
};

constexpr Input inputs[] = {{"cage", 1, false},    {"stitched cage", 1, false}, {"grids", 1, false},
                            {"quads", 1, false},   {"triangles", 1, false},     {"irregular triangles", 1, false},
                            {"several", 1, false}, {"grids", 1, true},          {"irregular triangles", 1, true},
                            {"cage", 3, false},    {"grids", 2, false},         {"irregular triangles", 3, false},
                            {"several", 2, true}};

TEST_P(ClosestPoints, AreThoseOfAllTriangles) {
  for (const Input& input : inputs) {
    SCOPED_TRACE(testing::Message() << input.name << ", " << input.numSteps << " steps, lossless " << input.isLossless);
    Surfaces surfaces;
    ASSERT_NO_FATAL_FAILURE(build(surfaces, input));
    Random random(41);
    for (float time : {0.0f, 0.35f, 1.0f}) {
      if (input.numSteps == 1 && time != 0) break;
      const std::vector<Triangle> triangles = surfaces.trianglesAt(time);
      ASSERT_GT(triangles.size(), 500u);
      for (int i = 0; i < 150; i++) {
        const CbvhPointQuery query = queryAt(randomPoint(random, triangles), time, INFINITY);
        SCOPED_TRACE(testing::Message() << "point " << query.x << " " << query.y << " " << query.z << " at " << time);
        CbvhClosestPoint found;
        ASSERT_NO_FATAL_FAILURE(expectClosest(surfaces, triangles, query, found));
        if (!(found.distance > 1e-6f)) continue;
        for (const double factor : {0.999, 1.001}) {
          const CbvhPointQuery limited = queryAt(pointOf(query), time, factor * found.distance);
          ASSERT_EQ(cbvhPointQuery(surfaces.group, &limited, nullptr), factor > 1) << factor;
        }
      }
    }
  }
}

// A function that ignores all points visits each triangle within the radius once.
TEST_P(ClosestPoints, FunctionsVisitAllTrianglesWithinTheRadius) {
  for (const Input& input : inputs) {
    SCOPED_TRACE(testing::Message() << input.name << ", " << input.numSteps << " steps");
    Surfaces surfaces;
    ASSERT_NO_FATAL_FAILURE(build(surfaces, input));
    const std::vector<Triangle> triangles = surfaces.trianglesAt(0.35f);
    Random random(42);
    for (int i = 0; i < 40; i++) {
      const double radius = random.magnitude(0.02, 5);
      CbvhPointQuery query = queryAt(randomPoint(random, triangles), 0.35f, radius);
      const Point p = pointOf(query);
      std::vector<double> visited;
      query.userPtr = &visited;
      query.function = [](CbvhPointFunctionArguments* args) {
        ((std::vector<double>*)args->userPtr)->push_back(args->point->distance);
        return 0;
      };
      EXPECT_EQ(cbvhPointQuery(surfaces.group, &query, nullptr), 0);
      size_t surely = 0, atMost = 0;
      for (const Triangle& t : triangles) {
        surely += t.distance(p) < radius * (1 - 1e-5);
        atMost += t.distance(p) < radius * (1 + 1e-5);
      }
      EXPECT_GE(visited.size(), surely);
      EXPECT_LE(visited.size(), atMost);
      for (double distance : visited) EXPECT_LE(distance, radius * (1 + 1e-6));
    }
  }
}

// A function may search for several neighbors, accept only some points, and start queries and rays.
TEST_P(ClosestPoints, FunctionsSelectPoints) {
  Surfaces surfaces;
  ASSERT_NO_FATAL_FAILURE(build(surfaces, {"several", 1, false}));
  const std::vector<Triangle> triangles = surfaces.trianglesAt(0);
  Random random(43);
  constexpr size_t count = 5;
  struct Search {
    const Surfaces* surfaces;
    std::multiset<double> distances;
  };
  for (int i = 0; i < 60; i++) {
    CbvhPointQuery query = queryAt(randomPoint(random, triangles), 0, INFINITY);
    const Point p = pointOf(query);
    Search search = {&surfaces, {}};
    query.userPtr = &search;
    query.function = [](CbvhPointFunctionArguments* args) {
      Search& search = *(Search*)args->userPtr;
      CbvhRayHit ray = rayFromAbove();
      cbvhIntersect1(search.surfaces->group, &ray, nullptr);
      const CbvhPointQuery inner = queryAt({args->point->x, args->point->y, args->point->z}, 0, INFINITY);
      cbvhPointQuery(search.surfaces->group, &inner, nullptr);
      search.distances.insert(args->point->distance);
      if (search.distances.size() > count) search.distances.erase(std::prev(search.distances.end()));
      if (search.distances.size() == count) args->radius = float(*search.distances.rbegin());
      return 0;
    };
    cbvhPointQuery(surfaces.group, &query, nullptr);
    std::multiset<double> expected;
    for (const Triangle& t : triangles) expected.insert(t.distance(p));
    ASSERT_EQ(search.distances.size(), size_t(count));
    auto e = expected.begin();
    for (double distance : search.distances) {
      ASSERT_NEAR(distance, *e, 2e-7 * *e + 1e-13);
      e++;
    }

    CbvhClosestPoint found = CbvhClosestPoint();
    query.function = [](CbvhPointFunctionArguments* args) { return int(args->point->geomID == 1); };
    ASSERT_EQ(cbvhPointQuery(surfaces.group, &query, &found), 1);
    double nearest = INFINITY;
    for (const Triangle& t : triangles)
      if (t.geomID == 1) nearest = std::min(nearest, t.distance(p));
    EXPECT_EQ(found.geomID, 1u);
    EXPECT_NEAR(found.distance, nearest, 2e-7 * nearest + 1e-13);
  }
}

std::string nameOfForm(const testing::TestParamInfo<std::tuple<std::string, std::string>>& info) {
  std::string name;
  for (char c : std::get<0>(info.param).substr(4) + std::get<1>(info.param))
    if (std::isalnum((unsigned char)c)) name += c;
  return name;
}
INSTANTIATE_TEST_SUITE_P(Forms, ClosestPoints,
                         testing::Combine(testing::ValuesIn(std::vector<std::string>{TEST_ISAS}),
                                          testing::Values(std::string("subdiv_accel=cbvh"),
                                                          std::string("subdiv_accel=cbvh.vert"))),
                         nameOfForm);

// Results, ties included, do not depend on the instruction set or the form.
TEST(ClosestPointsOfAllIsas, AreEqualToTheBit) {
  const Input input = {"several", 1, false};
  std::vector<CbvhClosestPoint> first;
  for (const char* isa : {TEST_ISAS})
    for (const char* form : {"subdiv_accel=cbvh", "subdiv_accel=cbvh.vert"}) {
      const Context context(std::string(isa) + "," + form);
      if (!context.handle) continue;
      SCOPED_TRACE(testing::Message() << isa << " " << form);
      Surfaces surfaces;
      Builder(surfaces, context.handle, input).add();
      surfaces.commit(context.handle);
      const std::vector<Triangle> triangles = surfaces.trianglesAt(0);
      Random random(44);
      std::vector<CbvhClosestPoint> all;
      for (int i = 0; i < 5000; i++) {
        const CbvhPointQuery query = queryAt(randomPoint(random, triangles), 0, INFINITY);
        all.emplace_back();
        std::memset(&all.back(), 0, sizeof(all.back()));
        ASSERT_EQ(cbvhPointQuery(surfaces.group, &query, &all.back()), 1);
      }
      if (first.empty()) first = all;
      for (size_t i = 0; i < all.size(); i++)
        ASSERT_EQ(std::memcmp(&all[i], &first[i], sizeof(all[i])), 0)
            << "point " << i << ": primitives " << all[i].primID << " and " << first[i].primID << ", distances "
            << all[i].distance << " and " << first[i].distance << ", u " << all[i].u << " and " << first[i].u;
    }
}

TEST(ClosestPointErrors, AreReportedByName) {
  const Context context("");
  Surfaces surfaces;
  Builder(surfaces, context.handle, {"grids", 1, false}).add();
  ASSERT_EQ(cbvhNewGroup(context.handle, surfaces.handles.data(), 1, &surfaces.group), CBVH_OK);
  auto expectError = [&](const CbvhPointQuery& query, const char* part) {
    EXPECT_EQ(cbvhPointQuery(surfaces.group, &query, nullptr), 0);
    EXPECT_NE(std::string(cbvhGetErrorText()).find(part), std::string::npos) << cbvhGetErrorText();
  };
  expectError(queryAt({0, 0, 0}, 0, 1), "cbvhCommitGroup");
  ASSERT_EQ(cbvhCommitGroup(surfaces.group), CBVH_OK);
  expectError(queryAt({0, NAN, 0}, 0, 1), "coordinate nan");
  expectError(queryAt({0, 0, INFINITY}, 0, 1), "coordinate inf");
  expectError(queryAt({0, 0, 0}, 0, -1), "radius");
  expectError(queryAt({0, 0, 0}, 0, NAN), "radius");
  CbvhClosestPoint found;
  const float p[] = {0, NAN, 0};
  EXPECT_EQ(cbvhFindClosestPoint(surfaces.handles[0], 0, 0, p, 1, &found), 0);
  EXPECT_NE(std::string(cbvhGetErrorText()).find("coordinate nan"), std::string::npos) << cbvhGetErrorText();
}

}} // namespace programs::test
