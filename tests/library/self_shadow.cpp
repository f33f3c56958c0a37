// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Secondary rays from a representation's own hits agree with GRID's rays from GRID's hits, except for a
 * bounded share. */

#include "measure/self_shadow.h"

#include "basics/parallel.h"
#include "building/built_scene.h"
#include "programs/view_options.h"
#include "scenes/catalogue.h"
#include "tracing/camera.h"
#include "tracing/trace_hits.h"

#include <gtest/gtest.h>

#include <optional>

namespace programs::test { namespace {

constexpr int level = 5;
constexpr ImageSize size = {512, 512};

struct Fixture {
  Fixture(const std::string& name, std::optional<float> amplitude)
    : model(loadModel(name, amplitude)),
      grid(built("grid")),
      camera(chooseCamera("full", model, *grid, size, threads)),
      primary(primaryRays(camera)),
      gridHits(traceClosest(*grid, primary, threads)) {
    shadows.raysPerHit = 2;
    shadows.offset.length = 0.5f * quadWidth();
  }

  static Model loadModel(const std::string& name, std::optional<float> amplitude) {
    SceneSettings settings;
    settings.scene = name;
    settings.amplitude = amplitude;
    settings.mapFolder = testing::TempDir();
    std::string warning;
    return loadScene(settings, warning);
  }

  std::unique_ptr<BuiltScene> built(const std::string& representation) const {
    BuildSettings settings;
    settings.level = level;
    return std::make_unique<BuiltScene>(model, parseRepresentations(representation, 2).front(), settings);
  }

  // Mean length of the edges in the patches' first rows.
  float quadWidth() const {
    BuildSettings settings;
    settings.level = level;
    const std::vector<Vec3f> vertices = tessellate(model, settings);
    double sum = 0;
    size_t n = 0;
    for (const Patch& patch : grid->layout().patches())
      for (unsigned i = 0; i < patch.resolution; i++, n++)
        sum += length(vertices[patch.firstVertex + i + 1] - vertices[patch.firstVertex + i]);
    return float(sum / double(n));
  }

  ShadowComparison compare(RTCScene scene, const std::vector<SurfaceHit>& hits) const {
    return compareShadows({grid->tracer(), gridHits}, {EmbreeTracer(scene), hits}, {primary, camera.footprint()},
                          shadows, threads);
  }

  ShadowComparison compare(const BuiltScene& scene) const {
    return compare(scene.handle(), traceClosest(scene, primary, threads));
  }

  const unsigned threads = threadCount(0);
  Model model;
  std::unique_ptr<BuiltScene> grid;
  Camera camera;
  std::vector<Ray> primary;
  std::vector<SurfaceHit> gridHits;
  ShadowSettings shadows;
};

double share(const ShadowComparison& c) { return double(c.all.sum()) / double(c.rays); }

class SelfShadow : public testing::Test {
protected:
  // fallback_faces is off because the tests are about leaves.
  static void expectAtMost(double bound, const Fixture& f) {
    const ShadowComparison grid = f.compare(*f.built("cgrid")), leaf = f.compare(*f.built("cleaf-only"));
    EXPECT_GT(leaf.rays, 100000u);
    EXPECT_EQ(grid.all.sum(), 0u) << "cGRID has GRID's triangles";
    EXPECT_LE(share(leaf), bound);
  }
};

TEST_F(SelfShadow, AtMostOneInAThousandOnGentleSurface) { expectAtMost(0.001, Fixture("cube", 0.001f)); }

TEST_F(SelfShadow, AtMostOneInAHundredOnFrog) { expectAtMost(0.01, Fixture("frog", std::nullopt)); }

}} // namespace programs::test
