// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The oracle against formulas, against Embree's own evaluation, and against surfaces
 * whose distance is known. */

#include "scenes/cube.h"
#include "test_random.h"
#include "tracing.h"
#include "true_errors.h"

#include <gtest/gtest.h>

namespace cbvh {
namespace {

/* (n+1)^2 control points over [0,n]^2. */
Cage sheet(unsigned n)
{
  Cage cage;
  cage.name = "sheet";
  for (unsigned y = 0; y <= n; y++)
    for (unsigned x = 0; x <= n; x++)
      cage.positions.push_back({float(x), float(y), 0});
  for (unsigned y = 0; y < n; y++)
    for (unsigned x = 0; x < n; x++)
    {
      const unsigned i = y * (n + 1) + x;
      cage.faceSizes.push_back(4);
      cage.faceIndices.insert(cage.faceIndices.end(), {i, i + 1, i + n + 2, i + n + 1});
    }
  return cage;
}

/* Closed: two faces of n vertices, n quads. */
Cage prism(unsigned n)
{
  Cage cage;
  cage.name = "prism";
  for (unsigned k = 0; k < 2; k++)
    for (unsigned i = 0; i < n; i++)
    {
      const double a = 2 * M_PI * i / n;
      cage.positions.push_back({float(std::cos(a)), float(std::sin(a)), k ? 0.8f : -0.8f});
    }
  cage.faceSizes = {n, n};
  for (unsigned i = 0; i < n; i++)
    cage.faceIndices.push_back(n - 1 - i);
  for (unsigned i = 0; i < n; i++)
    cage.faceIndices.push_back(n + i);
  for (unsigned i = 0; i < n; i++)
  {
    cage.faceSizes.push_back(4);
    cage.faceIndices.insert(cage.faceIndices.end(), {i, (i + 1) % n, n + (i + 1) % n, n + i});
  }
  return cage;
}

/* Closed: 2n quads; the last two vertices have valence n. */
Cage trapezohedron(unsigned n)
{
  Cage cage;
  cage.name = "trapezohedron";
  for (unsigned i = 0; i < 2 * n; i++)
  {
    const double a = M_PI * i / n;
    cage.positions.push_back({float(std::cos(a)), float(std::sin(a)), i & 1 ? -0.3f : 0.3f});
  }
  cage.positions.push_back({0, 0, 1});
  cage.positions.push_back({0, 0, -1});
  cage.faceSizes.assign(2 * n, 4);
  for (unsigned i = 0; i < n; i++)
  {
    const unsigned a = 2 * i, b = 2 * i + 1, c = (2 * i + 2) % (2 * n), d = (2 * i + 3) % (2 * n);
    cage.faceIndices.insert(cage.faceIndices.end(), {2 * n, a, b, c, 2 * n + 1, d, c, b});
  }
  return cage;
}

Cage moved(Cage cage, Random& random, double size)
{
  for (Vec3f& p : cage.positions)
    p += Vec3f{float(random.uniform(-size, size)), float(random.uniform(-size, size)), float(random.uniform(-size, size))};
  return cage;
}

/* Some of the edges, all equally sharp. */
Cage creased(Cage cage, float sharpness, Random& random)
{
  const FaceBorders borders(cage);
  for (unsigned face = 0; face < cage.numFaces(); face++)
    for (unsigned i = 0, n = cage.faceSizes[face]; i < n; i++)
    {
      const unsigned a = cage.faceIndices[borders.corner(face, i)], b = cage.faceIndices[borders.corner(face, (i + 1) % n)];
      if (a < b && random.chance(0.3))
        cage.creaseEdges.push_back({a, b});
    }
  cage.creaseSharpness.assign(cage.creaseEdges.size(), sharpness);
  return cage;
}

/* The ring about the middle of a trapezohedron. */
Cage belted(Cage cage, float sharpness)
{
  const unsigned n = unsigned(cage.numFaces());
  for (unsigned i = 0; i < n; i++)
    cage.creaseEdges.push_back({i, (i + 1) % n});
  cage.creaseSharpness.assign(n, sharpness);
  return cage;
}

Model modelOf(const Cage& cage)
{
  Model model;
  model.name = cage.name;
  model.cage = cage;
  return model;
}

PatchPoint randomPoint(const Cage& cage, const TrueSurface& surface, Random& random)
{
  unsigned face;
  do
    face = random.below(unsigned(cage.numFaces()));
  while (!surface.has(face));
  const unsigned size = cage.faceSizes[face];
  return {face, size == 4 ? 0 : random.below(size), random.uniform(), random.uniform()};
}

/* --- against formulas ------------------------------------------------------------ */

TEST(LimitSurface, APlaneStaysAPlane)
{
  Cage cage = sheet(5);
  for (Vec3f& p : cage.positions)
    p.z = 0.25f * p.x - 0.5f * p.y;
  const LimitSurface limit(cage);
  for (double u : {0.0, 0.3, 1.0})
    for (double v : {0.0, 0.75, 1.0})
    {
      const LimitSample s = limit.evaluate({12, 0, u, v}); // the middle face
      EXPECT_NEAR(s.p.x, 2 + u, 1e-12);
      EXPECT_NEAR(s.p.y, 2 + v, 1e-12);
      EXPECT_NEAR(s.p.z, 0.25 * s.p.x - 0.5 * s.p.y, 1e-12);
      EXPECT_NEAR(length(s.du - Vec3d{1, 0, 0.25}), 0, 1e-12);
      EXPECT_NEAR(length(s.duv), 0, 1e-12);
    }
}

/* Uniform cubic B-spline weights and their first two derivatives. */
void spline(double t, double w[3][4])
{
  const double s = 1 - t;
  const double values[3][4] = {
    {s * s * s / 6, (3 * t * t * t - 6 * t * t + 4) / 6, (3 * s * s * s - 6 * s * s + 4) / 6, t * t * t / 6},
    {-s * s / 2, (3 * t * t - 4 * t) / 2, (-3 * s * s + 4 * s) / 2, t * t / 2},
    {s, 3 * t - 2, 3 * s - 2, t}};
  std::copy(&values[0][0], &values[0][0] + 12, &w[0][0]);
}

TEST(LimitSurface, RegularPatchesAreBicubicSplines)
{
  Random random(1);
  const Cage cage = moved(sheet(3), random, 0.4);
  const LimitSurface limit(cage);
  for (int i = 0; i < 100; i++)
  {
    const double u = random.uniform(), v = random.uniform();
    double wu[3][4], wv[3][4];
    spline(u, wu);
    spline(v, wv);
    const LimitSample s = limit.evaluate({4, 0, u, v});
    const auto expect = [&](Vec3d found, int du, int dv) {
      Vec3d sum;
      for (int y = 0; y < 4; y++)
        for (int x = 0; x < 4; x++)
          sum += wu[du][x] * wv[dv][y] * toDouble(cage.positions[size_t(4 * y + x)]);
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

TEST(LimitSurface, CubeCornersComeToAHalf)
{
  /* (n^2 v + 4 sum of neighbours + sum of those across the faces) / (n (n + 5)) */
  const LimitSample s = LimitSurface(makeCube().cage).evaluate({5, 0, 1, 1});
  EXPECT_NEAR(length(s.p - Vec3d{0.5, 0.5, 0.5}), 0, 1e-12);
}

TEST(LimitSurface, VerticesOfAnyValenceHaveTheKnownLimit)
{
  Random random(2);
  for (unsigned n = 3; n <= 10; n++)
  {
    const Cage cage = moved(trapezohedron(n), random, 0.2);
    const LimitSurface limit(cage);
    Vec3d neighbours, across;
    for (unsigned i = 0; i < n; i++)
    {
      neighbours += toDouble(cage.positions[2 * i]);
      across += toDouble(cage.positions[2 * i + 1]);
    }
    const Vec3d expected = (double(n * n) * toDouble(cage.positions[2 * n]) + 4.0 * neighbours + across) * (1.0 / (n * (n + 5.0)));
    for (unsigned face = 0; face < 2 * n; face += 2)
      EXPECT_NEAR(length(limit.evaluate({face, 0, 0, 0}).p - expected), 0, 1e-7) << "valence " << n;
  }
}

TEST(LimitSurface, DerivativesAreThoseOfThePosition)
{
  Random random(3);
  for (const Cage& cage : {moved(prism(5), random, 0.2), moved(trapezohedron(7), random, 0.2)})
  {
    const Model model = modelOf(cage);
    const TrueSurface surface(model);
    const LimitSurface limit(cage);
    constexpr double h = 1e-6;
    for (int i = 0; i < 200; i++)
    {
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

/* --- against Embree --------------------------------------------------------------- */

struct Deviation
{
  double position = 0, angle = 0;
};

/* margin: of points from the borders of their patch. */
Deviation deviationFromEmbree(const Cage& cage, double margin, Random& random)
{
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
  for (int i = 0; i < 2000; i++)
  {
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

/* Some ulps of coordinates up to 4. Near extraordinary vertices Embree takes tangents
 * from differences over 2^-10 of a face, which lets those ulps grow 2^10-fold. */
constexpr double ulp = 0x1p-23, positionBound = 4 * 4 * ulp, angleBound = 4 * ulp * 0x1p10;

void expectEmbrees(const Cage& cage, double margin, Random& random)
{
  const Deviation d = deviationFromEmbree(cage, margin, random);
  EXPECT_LT(d.position, positionBound) << cage.name << " of " << cage.numFaces() << " faces";
  EXPECT_LT(d.angle, angleBound) << cage.name << " of " << cage.numFaces() << " faces";
}

TEST(LimitSurface, EqualsEmbreesOnSmoothCages)
{
  Random random(4);
  expectEmbrees(makeCube().cage, 0, random);
  for (unsigned n = 3; n <= 10; n++)
  {
    expectEmbrees(moved(trapezohedron(n), random, 0.1), 0, random);
    expectEmbrees(moved(prism(n), random, 0.1), 0, random);
  }
}

TEST(LimitSurface, EqualsEmbreesOnOpenSheetsWithHoles)
{
  Random random(5);
  Cage cage = moved(sheet(4), random, 0.3);
  for (BoundaryRule rule : {BoundaryRule::EdgeAndCorner, BoundaryRule::None})
  {
    cage.boundary = rule;
    expectEmbrees(cage, 0, random);
  }
  cage.boundary = BoundaryRule::EdgeAndCorner;
  cage.holes = {5};
  expectEmbrees(cage, 0, random);
  cage.boundary = BoundaryRule::EdgeOnly; // but for corner faces
  cage.holes = {0, 3, 12, 15};
  cage.cornerVertices = {1, 3, 5, 9, 15, 19, 21, 23};
  cage.cornerSharpness.assign(8, INFINITY);
  expectEmbrees(cage, 0, random);
}

/* Away from borders of patches: along infinitely sharp creases either side closes the
 * last 2^-10 of a face its own way. */
TEST(LimitSurface, EqualsEmbreesWithCreasesAndCorners)
{
  Random random(6);
  constexpr double margin = 0x1p-8;
  for (unsigned n = 3; n <= 10; n++)
  {
    const Cage t = moved(trapezohedron(n), random, 0.1), p = moved(prism(n), random, 0.1);
    for (float sharpness : {1.0f, 2.0f, INFINITY})
    {
      expectEmbrees(creased(t, sharpness, random), margin, random);
      expectEmbrees(creased(p, sharpness, random), margin, random);
    }
    for (float sharpness : {0.4f, 1.7f, 2.5f})
    {
      expectEmbrees(belted(t, sharpness), margin, random);
      Cage cornered = t;
      cornered.cornerVertices = {0, n + 1};
      cornered.cornerSharpness = {sharpness, INFINITY};
      expectEmbrees(cornered, margin, random);
    }
  }
}

/* --- walking over borders ---------------------------------------------------------- */

/* A plane of unit squares, each with its first corner anywhere. */
TEST(PatchWalk, LinesStayStraightHoweverFacesAreTurned)
{
  Random random(6);
  constexpr unsigned n = 8;
  Cage cage = sheet(n);
  for (unsigned face = 0; face < n * n; face++)
    std::rotate(cage.faceIndices.begin() + 4 * face, cage.faceIndices.begin() + 4 * face + random.below(4),
                cage.faceIndices.begin() + 4 * face + 4);
  const Model model = modelOf(cage);
  const TrueSurface surface(model);
  for (int i = 0; i < 1000; i++)
  {
    const PatchPoint p{(2 + random.below(4)) * n + 2 + random.below(4), 0, random.uniform(), random.uniform()};
    const TruePoint from = surface.evaluate(p);
    const double u = random.uniform(-1, 1), v = random.uniform(-1, 1);
    const TruePoint to = surface.evaluate(surface.patches().go(p, u, v));
    EXPECT_NEAR(length(from.position + u * from.du + v * from.dv - to.position), 0, 1e-9);
  }
}

TEST(PatchWalk, BordersAreCrossedWhereTheSurfaceGoesOn)
{
  Random random(7);
  Cage holed = moved(sheet(4), random, 0.3);
  holed.holes = {5, 10};
  for (const Cage& cage : {prism(3), prism(6), trapezohedron(4), holed})
  {
    const Model model = modelOf(cage);
    const TrueSurface surface(model);
    for (int i = 0; i < 1000; i++)
    {
      PatchPoint p = randomPoint(cage, surface, random);
      const unsigned edge = random.below(4);
      double& across = edge % 2 ? p.u : p.v;
      double& along = edge % 2 ? p.v : p.u;
      const double border = edge == 1 || edge == 2 ? 1 : 0, outward = border == 1 ? 1 : -1;
      along = 0.1 + 0.8 * along;
      constexpr double least = 1e-9;
      const double side = random.uniform(-0.1, 0.1);
      across = border;
      const PatchPoint q = surface.patches().go(p, edge % 2 ? outward * least : side, edge % 2 ? side : outward * least);
      along += side;
      EXPECT_LT(length(surface.evaluate(p).position - surface.evaluate(q).position), 1e-7)
        << "face " << p.face << " edge " << edge << " to face " << q.face;

      /* As deep on the far side as the step goes beyond the border. */
      along -= side;
      const double depth = random.uniform(0.01, 0.2);
      const PatchPoint far = surface.patches().go(p, edge % 2 ? outward * depth : 0, edge % 2 ? 0 : outward * depth);
      if (far.face == p.face && far.subPatch == p.subPatch)
        continue; // a boundary
      const unsigned here = cage.faceSizes[p.face], there = cage.faceSizes[far.face];
      const double scale = here == 4 && there != 4 ? 2 : here != 4 && there == 4 ? 0.5 : 1;
      const double depths[4] = {far.u, far.v, 1 - far.u, 1 - far.v};
      EXPECT_TRUE(std::any_of(depths, depths + 4, [&](double d) { return std::abs(d - scale * depth) < 1e-9; }));
    }
  }
}

/* --- distances ------------------------------------------------------------------- */

/* Smooth over all borders of the sheet: its faces are the squares of a plane. */
class Waves : public Displacement
{
public:
  Waves(unsigned n, float height) : n(n), height(height) {}
  void offsets(const SurfacePoints& points, float* out) const override
  {
    for (size_t i = 0; i < points.n; i++)
    {
      const double x = points.face % n + points.u[i], y = points.face / n + points.v[i];
      out[i] = float(height * std::sin(1.3 * x + 0.4) * std::cos(0.9 * y));
    }
  }

private:
  unsigned n;
  float height;
};

Model wavySheet(float height = 0.2f)
{
  Model model = modelOf(sheet(8));
  model.displacement = std::make_shared<Waves>(8, height);
  return model;
}

TEST(TrueSurface, IsDisplacedAlongTheNormal)
{
  Random random(8);
  const Model model = wavySheet();
  const TrueSurface surface(model);
  for (int i = 0; i < 100; i++)
  {
    const unsigned x = 2 + random.below(4), y = 2 + random.below(4);
    const PatchPoint p{y * 8 + x, 0, random.uniform(), random.uniform()};
    const double sx = x + p.u, sy = y + p.v;
    const TruePoint found = surface.evaluate(p);
    EXPECT_NEAR(length(found.position - Vec3d{sx, sy, 0.2 * std::sin(1.3 * sx + 0.4) * std::cos(0.9 * sy)}), 0, 1e-6);
    EXPECT_NEAR(length(found.du - Vec3d{1, 0, 0.26 * std::cos(1.3 * sx + 0.4) * std::cos(0.9 * sy)}), 0, 3e-4);
    EXPECT_NEAR(length(found.dv - Vec3d{0, 1, -0.18 * std::sin(1.3 * sx + 0.4) * std::sin(0.9 * sy)}), 0, 3e-4);
  }
}

TEST(TrueSurface, APointOffAlongTheNormalIsFoundAtThatDistance)
{
  Random random(9);
  const Model cube = makeCube(0.0f);
  const Model blob = modelOf(moved(prism(5), random, 0.1));
  const Model wavy = wavySheet();
  for (const Model* model : {&cube, &blob, &wavy})
  {
    const TrueSurface surface(*model);
    for (int i = 0; i < 500; i++)
    {
      PatchPoint p = randomPoint(model->cage, surface, random);
      if (model == &wavy)
        p.face = (2 + random.below(4)) * 8 + 2 + random.below(4);
      const TruePoint foot = surface.evaluate(p);
      const double distance = random.magnitude(1e-6, 0.05) * (random.chance(0.5) ? 1 : -1);
      const Vec3d x = foot.position + distance * normalize(cross(foot.du, foot.dv));
      /* A start some cells off, often on another face. */
      constexpr double cell = 1.0 / 16;
      const PatchPoint start = surface.patches().go(p, random.uniform(-3, 3) * cell, random.uniform(-3, 3) * cell);
      const TruePoint found = surface.nearest(x, start, cell);
      EXPECT_NEAR(length(found.position - x), std::abs(distance), 1e-6 + 1e-4 * std::abs(distance)) << model->name;
      EXPECT_NEAR(length(found.position - foot.position), 0, 1e-3 * std::abs(distance) + 1e-5) << model->name;
    }
  }
}

/* Between spikes descent alone ends in the wrong dent. */
TEST(TrueSurface, NoDenseSampleOfTheWindowIsNearer)
{
  Random random(10);
  const Model model = makeCube();
  const TrueSurface surface(model);
  constexpr double cell = 1.0 / 32, window = 4 * cell;
  constexpr int dense = 32;
  for (int i = 0; i < 200; i++)
  {
    const PatchPoint start{random.below(6), 0, random.uniform(0.2, 0.8), random.uniform(0.2, 0.8)};
    const TruePoint above = surface.evaluate(start);
    const Vec3d x = above.position + 0.05 * Vec3d{random.normal(), random.normal(), random.normal()};
    const double found = length(surface.nearest(x, start, cell).position - x);
    double least = INFINITY;
    for (int k = -dense; k <= dense; k++)
      for (int j = -dense; j <= dense; j++)
      {
        const PatchPoint p{start.face, 0, start.u + window * j / dense, start.v + window * k / dense};
        least = std::min(least, length(surface.evaluate(p).position - x));
      }
    EXPECT_LE(found, least * (1 + 1e-6)) << "from " << start.u << ", " << start.v;
  }
}

TEST(TrueSurface, LinesMeetItWhereTheyWereAimed)
{
  Random random(11);
  const Model model = makeCube(0.02f);
  const TrueSurface surface(model);
  for (int i = 0; i < 500; i++)
  {
    const TruePoint aim = surface.evaluate(randomPoint(model.cage, surface, random));
    const Vec3d n = normalize(cross(aim.du, aim.dv));
    const Vec3d origin = aim.position + 3.0 * n + Vec3d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    constexpr double cell = 1.0 / 64;
    const TruePoint start = surface.evaluate(surface.patches().go(aim.at, 0.3 * cell, -0.4 * cell));
    const auto met = surface.crossing(origin, normalize(aim.position - origin), start, cell, 1e-9);
    ASSERT_TRUE(met);
    EXPECT_NEAR(length(met->position - aim.position), 0, 1e-6);
  }
}

/* --- errors of hits ----------------------------------------------------------------- */

struct Traced
{
  BuiltScene scene;
  std::vector<Ray> rays;
  std::vector<SurfaceHit> hits;
  float footprint;
};

Traced trace(const Model& model, int level)
{
  BuildSettings settings;
  settings.level = level;
  settings.threads = 1;
  BuiltScene scene(model, {RepresentationKind::Grid}, settings);
  const Camera camera = Camera::fit(model.positions(), 0, model.view, 30, {96, 96});
  std::vector<Ray> rays = primaryRays(camera);
  std::vector<SurfaceHit> hits = traceClosest(scene, rays, 1);
  return {std::move(scene), std::move(rays), std::move(hits), camera.footprint()};
}

TrueErrors errorsOf(const Model& model, const TrueSurface& surface, const Traced& t)
{
  const std::vector<size_t> sample = sampleOfHits(t.hits, 3000, 1);
  return compareToTrueSurface({model, surface, t.rays, sample, t.footprint}, t.hits, t.scene.layout(), 1);
}

TEST(TrueErrors, OfATessellationFallByFourALevel)
{
  const Model model = makeCube(0.0f);
  const TrueSurface surface(model);
  TrueErrors last;
  for (int level = 2; level <= 6; level++)
  {
    const TrueErrors e = errorsOf(model, surface, trace(model, level));
    if (level > 2)
    {
      EXPECT_NEAR(last.rmse / e.rmse, 4, 0.4) << "level " << level;
      EXPECT_NEAR(last.median / e.median, 4, 0.4) << "level " << level;
      EXPECT_NEAR(last.normalMedian / e.normalMedian, 2, 0.2) << "level " << level;
    }
    EXPECT_GT(e.bias, 0) << "a mesh with its vertices on a convex surface lies behind it";
    last = e;
  }
}

TEST(TrueErrors, ABiasHasItsSizeAndSign)
{
  const Model model = makeCube(0.0f);
  const TrueSurface surface(model);
  Traced traced = trace(model, 6);
  const std::vector<SurfaceHit> hits = traced.hits;
  const double own = errorsOf(model, surface, traced).bias;
  for (double pixels : {-1.5, -0.1, 0.1, 1.5})
  {
    for (size_t i = 0; i < hits.size(); i++)
      traced.hits[i].t = hits[i].t * float(1 + pixels * traced.footprint);
    /* A hit that moves off the silhouette is no longer within 5 pixels of it. */
    EXPECT_NEAR(errorsOf(model, surface, traced).bias, own + pixels, 0.02) << pixels;
  }
}

TEST(TrueErrors, CopiesAreMeasuredWhereTheyStand)
{
  Model model = makeCube(0.01f);
  const TrueErrors alone = errorsOf(model, TrueSurface(model), trace(model, 4));
  model.copies = {{{1, 2, 3}, 0.7f, 2.0f}, {{9, 2, 3}, -0.4f, 3.0f}};
  const TrueErrors both = errorsOf(model, TrueSurface(model), trace(model, 4));
  EXPECT_LT(both.rmseWorld, 4 * alone.rmseWorld) << "of scale 2 and 3";
  EXPECT_GT(both.rmseWorld, alone.rmseWorld);
  EXPECT_LT(both.normalMedian, 1.5 * alone.normalMedian);
  EXPECT_LT(both.uvMedian, 0.1);
}

TEST(TrueErrors, TheSampleIsFixedBySeedAndComplete)
{
  std::vector<SurfaceHit> hits(1000);
  for (size_t i = 0; i < hits.size(); i += 2)
    hits[i].t = 1;
  EXPECT_EQ(sampleOfHits(hits, 1000, 1).size(), 500u);
  const std::vector<size_t> some = sampleOfHits(hits, 100, 1);
  EXPECT_EQ(some.size(), 100u);
  EXPECT_EQ(some, sampleOfHits(hits, 100, 1));
  EXPECT_NE(some, sampleOfHits(hits, 100, 2));
  for (size_t i : some)
    EXPECT_TRUE(hits[i].hit());
}

} // namespace
} // namespace cbvh
