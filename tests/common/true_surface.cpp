// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Surfaces of known distance, and hits with known errors. */

#include "measure/true_errors.h"
#include "building/built_scene.h"
#include "scenes/cube.h"
#include "support/random_cages.h"
#include "tracing/trace_hits.h"

#include <gtest/gtest.h>

namespace programs::test { namespace {

/* --- distances ------------------------------------------------------------------- */

/* Smooth over all borders of the sheet: its faces are the squares of a plane. */
class Waves : public Displacement {
public:
  Waves(unsigned n, float height) : n(n), height(height) {}
  void offsets(const SurfacePoints& points, float* out) const override {
    for (size_t i = 0; i < points.n; i++) {
      const double x = points.face % n + points.u[i], y = points.face / n + points.v[i];
      out[i] = float(height * std::sin(1.3 * x + 0.4) * std::cos(0.9 * y));
    }
  }

private:
  unsigned n;
  float height;
};

Model wavySheet(float height = 0.2f) {
  Model model = modelOf(sheet(8));
  model.displacement = std::make_shared<Waves>(8, height);
  return model;
}

TEST(TrueSurface, IsDisplacedAlongTheNormal) {
  Random random(8);
  const Model model = wavySheet();
  const TrueSurface surface(model);
  for (int i = 0; i < 100; i++) {
    const unsigned x = 2 + random.below(4), y = 2 + random.below(4);
    const PatchPoint p{y * 8 + x, 0, random.uniform(), random.uniform()};
    const double sx = x + p.u, sy = y + p.v;
    const TruePoint found = surface.evaluate(p);
    EXPECT_NEAR(length(found.position - Vec3d{sx, sy, 0.2 * std::sin(1.3 * sx + 0.4) * std::cos(0.9 * sy)}), 0, 1e-6);
    EXPECT_NEAR(length(found.du - Vec3d{1, 0, 0.26 * std::cos(1.3 * sx + 0.4) * std::cos(0.9 * sy)}), 0, 3e-4);
    EXPECT_NEAR(length(found.dv - Vec3d{0, 1, -0.18 * std::sin(1.3 * sx + 0.4) * std::sin(0.9 * sy)}), 0, 3e-4);
  }
}

/* The same surface by displacement vectors, shifted sideways. */
class WavesByVectors : public Waves {
public:
  using Waves::Waves;
  bool isAlongNormals() const override { return false; }
  void vectors(const SurfacePoints& points, const Vec3f* normals, Vec3f* out) const override {
    std::vector<float> heights(points.n);
    offsets(points, heights.data());
    for (size_t i = 0; i < points.n; i++) out[i] = heights[i] * normals[i] + Vec3f{2.0f * heights[i], 0, 0};
  }
};

TEST(TrueSurface, IsDisplacedByVectors) {
  Random random(10);
  Model along = wavySheet(), aside = along;
  aside.displacement = std::make_shared<WavesByVectors>(8, 0.2f);
  const TrueSurface a(along), b(aside);
  for (int i = 0; i < 100; i++) {
    const PatchPoint p{(2 + random.below(4)) * 8 + 2 + random.below(4), 0, random.uniform(), random.uniform()};
    const TruePoint x = a.evaluate(p), y = b.evaluate(p);
    const auto pushed = [](Vec3d v) { return v + Vec3d{2.0 * v.z, 0, 0}; };
    EXPECT_NEAR(length(y.position - pushed(x.position)), 0, 1e-6);
    EXPECT_NEAR(length(y.du - pushed(x.du)), 0, 1e-3);
    EXPECT_NEAR(length(y.dv - pushed(x.dv)), 0, 1e-3);
  }
}

/* Embree's vertices lie on it, including copies that are rotated and scaled. */
TEST(TrueSurface, VectorsRotateAndScaleWithCopies) {
  Model model = wavySheet();
  model.displacement = std::make_shared<WavesByVectors>(8, 0.2f);
  model.copies = {Placement(), Placement{{3, 1, 2}, 0.7f, 2.5f}};
  BuildSettings settings;
  settings.level = 2;
  settings.threads = 1;
  const std::vector<Vec3f> vertices = tessellate(model, settings);
  const PatchLayout layout(model.cage, settings.level);
  const Patch& patch = layout.patches()[27]; // inside the sheet; corners have no tangents
  const size_t n = vertices.size() / 2;
  for (size_t i = patch.firstVertex; i < patch.firstVertex + 25; i++)
    ASSERT_NEAR(length(vertices[n + i] - model.copies[1].apply(vertices[i])), 0, 1e-5) << i;
  const TrueSurface surface(model);
  const Vec3f vertex = vertices[patch.firstVertex + 2 * (patch.resolution + 1) + 1];
  EXPECT_NEAR(length(toDouble(vertex) - surface.evaluate({patch.face, 0, 0.25, 0.5}).position), 0, 1e-5);
}

TEST(TrueSurface, PointAlongTheNormalIsFoundAtItsDistance) {
  Random random(9);
  const Model cube = makeCube(0.0f);
  const Model blob = modelOf(moved(prism(5), random, 0.1));
  const Model wavy = wavySheet();
  for (const Model* model : {&cube, &blob, &wavy}) {
    const TrueSurface surface(*model);
    for (int i = 0; i < 500; i++) {
      PatchPoint p = randomPoint(model->cage, surface, random);
      if (model == &wavy) p.face = (2 + random.below(4)) * 8 + 2 + random.below(4);
      const TruePoint foot = surface.evaluate(p);
      const double distance = random.magnitude(1e-6, 0.05) * (random.chance(0.5) ? 1 : -1);
      const Vec3d x = foot.position + distance * normalize(cross(foot.du, foot.dv));
      /* Starts some cells away, often on another face. */
      constexpr double cell = 1.0 / 16;
      const PatchPoint start = surface.patches().advance(p, random.uniform(-3, 3) * cell, random.uniform(-3, 3) * cell);
      const TruePoint found = surface.nearest(x, start, cell);
      EXPECT_NEAR(length(found.position - x), std::abs(distance), 1e-6 + 1e-4 * std::abs(distance)) << model->name;
      EXPECT_NEAR(length(found.position - foot.position), 0, 1e-3 * std::abs(distance) + 1e-5) << model->name;
    }
  }
}

/* Between spikes, descent alone ends in the wrong local minimum. */
TEST(TrueSurface, NoDenseSampleOfTheWindowIsNearer) {
  Random random(10);
  const Model model = makeCube();
  const TrueSurface surface(model);
  constexpr double cell = 1.0 / 32, window = 4 * cell;
  constexpr int dense = 32;
  for (int i = 0; i < 200; i++) {
    const PatchPoint start{random.below(6), 0, random.uniform(0.2, 0.8), random.uniform(0.2, 0.8)};
    const TruePoint above = surface.evaluate(start);
    const Vec3d x = above.position + 0.05 * Vec3d{random.normal(), random.normal(), random.normal()};
    const double found = length(surface.nearest(x, start, cell).position - x);
    double least = INFINITY;
    for (int k = -dense; k <= dense; k++)
      for (int j = -dense; j <= dense; j++) {
        const PatchPoint p{start.face, 0, start.u + window * j / dense, start.v + window * k / dense};
        least = std::min(least, length(surface.evaluate(p).position - x));
      }
    EXPECT_LE(found, least * (1 + 1e-6)) << "from " << start.u << ", " << start.v;
  }
}

TEST(TrueSurface, LinesHitItWhereTheyAreAimed) {
  Random random(11);
  const Model model = makeCube(0.02f);
  const TrueSurface surface(model);
  for (int i = 0; i < 500; i++) {
    const TruePoint aim = surface.evaluate(randomPoint(model.cage, surface, random));
    const Vec3d n = normalize(cross(aim.du, aim.dv));
    const Vec3d origin =
        aim.position + 3.0 * n + Vec3d{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    constexpr double cell = 1.0 / 64;
    const TruePoint start = surface.evaluate(surface.patches().advance(aim.at, 0.3 * cell, -0.4 * cell));
    const auto met = surface.crossing(origin, normalize(aim.position - origin), start, cell, 1e-9);
    ASSERT_TRUE(met);
    EXPECT_NEAR(length(met->position - aim.position), 0, 1e-6);
  }
}

/* --- errors of hits ----------------------------------------------------------------- */

struct Traced {
  BuiltScene scene;
  std::vector<Ray> rays;
  std::vector<SurfaceHit> hits;
  float footprint;
};

Traced trace(const Model& model, int level) {
  BuildSettings settings;
  settings.level = level;
  settings.threads = 1;
  BuiltScene scene(model, {RepresentationKind::Grid}, settings);
  const Camera camera = Camera::fit(model.positions(), 0, model.view, 30, {96, 96});
  std::vector<Ray> rays = primaryRays(camera);
  std::vector<SurfaceHit> hits = traceClosest(scene, rays, 1);
  return {std::move(scene), std::move(rays), std::move(hits), camera.footprint()};
}

TrueErrors errorsOf(const Model& model, const TrueSurfaces& surfaces, const Traced& t) {
  const std::vector<size_t> sample = sampleHits(t.hits, 3000, 1);
  return compareToTrueSurface({model, surfaces, t.rays, sample, t.footprint}, t.hits, t.scene.layout(), 1);
}

TEST(TrueErrors, TessellationErrorDecreasesByFourPerLevel) {
  const Model model = makeCube(0.0f);
  const TrueSurfaces surfaces(model);
  TrueErrors last;
  for (int level = 2; level <= 6; level++) {
    const TrueErrors e = errorsOf(model, surfaces, trace(model, level));
    if (level > 2) {
      EXPECT_NEAR(last.rmse / e.rmse, 4, 0.4) << "level " << level;
      EXPECT_NEAR(last.median / e.median, 4, 0.4) << "level " << level;
      EXPECT_NEAR(last.normalMedian / e.normalMedian, 2, 0.2) << "level " << level;
    }
    EXPECT_GT(e.bias, 0) << "a mesh with its vertices on a convex surface is inside of it";
    last = e;
  }
}

TEST(TrueErrors, BiasHasTheRightSizeAndSign) {
  const Model model = makeCube(0.0f);
  const TrueSurfaces surfaces(model);
  Traced traced = trace(model, 6);
  const std::vector<SurfaceHit> hits = traced.hits;
  const double own = errorsOf(model, surfaces, traced).bias;
  for (double pixels : {-1.5, -0.1, 0.1, 1.5}) {
    for (size_t i = 0; i < hits.size(); i++) traced.hits[i].t = hits[i].t * float(1 + pixels * traced.footprint);
    /* A hit that moves off the silhouette is not within 5 pixels of it any more. */
    EXPECT_NEAR(errorsOf(model, surfaces, traced).bias, own + pixels, 0.02) << pixels;
  }
}

TEST(TrueErrors, CopiesAreMeasuredAtTheirPositions) {
  Model model = makeCube(0.01f);
  const TrueErrors alone = errorsOf(model, TrueSurfaces(model), trace(model, 4));
  model.copies = {{{1, 2, 3}, 0.7f, 2.0f}, {{9, 2, 3}, -0.4f, 3.0f}};
  const TrueErrors both = errorsOf(model, TrueSurfaces(model), trace(model, 4));
  EXPECT_LT(both.rmseWorld, 4 * alone.rmseWorld) << "scales 2 and 3";
  EXPECT_GT(both.rmseWorld, alone.rmseWorld);
  EXPECT_LT(both.normalMedian, 1.5 * alone.normalMedian);
  EXPECT_LT(both.uvMedian, 0.1);
}

TEST(TrueErrors, SampleIsDeterminedBySeedAndComplete) {
  std::vector<SurfaceHit> hits(1000);
  for (size_t i = 0; i < hits.size(); i += 2) hits[i].t = 1;
  EXPECT_EQ(sampleHits(hits, 1000, 1).size(), 500u);
  const std::vector<size_t> some = sampleHits(hits, 100, 1);
  EXPECT_EQ(some.size(), 100u);
  EXPECT_EQ(some, sampleHits(hits, 100, 1));
  EXPECT_NE(some, sampleHits(hits, 100, 2));
  for (size_t i : some) EXPECT_TRUE(hits[i].hit());
}

}} // namespace programs::test
