// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The parts of cbvh_viewer that do not require a window. */

#include "basics/error.h"
#include "basics/progress.h"
#include "layout.h"
#include "measure/hit_metrics.h"
#include "picture.h"
#include "programs/opened_files.h"
#include "programs/view_options.h"
#include "tracing/ray_sets.h"
#include "tracing/trace_hits.h"
#include "viewpoint.h"
#include "worker.h"

#include <chrono>
#include <gtest/gtest.h>
#include <stdexcept>
#include <thread>

namespace programs::test { namespace {

/* --- the viewpoint ----------------------------------------------------------------------- */

constexpr ImageSize size{640, 480};

Viewpoint someViewpoint() { return Viewpoint(Camera({3, 2, 5}, {0.5f, 0.25f, -1}, {0, 1, 0}, 40, size), {0, 1, 0}); }

/* Maps a pixel to a point at a distance, and back. */
Vec3f pointAt(const Camera& camera, float x, float y, float distance) {
  return camera.eye() + distance * camera.direction(x, y);
}

Vec2f pixelOf(const Camera& camera, Vec3f point) {
  const Vec3f forward = normalize(camera.lookAt() - camera.eye()), right = normalize(cross(forward, Vec3f{0, 1, 0}));
  const Vec3f v = point - camera.eye();
  const float scale = 1.0f / (dot(v, forward) * camera.footprint());
  return {dot(v, right) * scale + 0.5f * float(size.width) - 0.5f,
          dot(v, cross(forward, right)) * scale + 0.5f * float(size.height) - 0.5f};
}

void expectNear(Vec3f a, Vec3f b, float tolerance = 1e-4f) {
  EXPECT_LT(length(a - b), tolerance) << a.x << " " << a.y << " " << a.z << " and " << b.x << " " << b.y << " " << b.z;
}

TEST(Viewpoint, PanKeepsThePointUnderTheMouse) {
  Viewpoint view = someViewpoint();
  const Vec3f direction = view.direction();
  const Vec3f point = pointAt(view.camera(size), 150, 300, 4.0f);
  view.pan(70, -45, dot(point - view.position(), direction), size);
  const Vec2f pixel = pixelOf(view.camera(size), point);
  EXPECT_NEAR(pixel.x, 220, 0.01f);
  EXPECT_NEAR(pixel.y, 255, 0.01f);
  expectNear(view.direction(), direction);
}

TEST(Viewpoint, ZoomKeepsThePixelOfThePointAndScalesAllDistances) {
  Viewpoint view = someViewpoint();
  const Vec3f point = pointAt(view.camera(size), 500, 100, 6.0f);
  const float before = view.distance(), toPoint = length(point - view.position());
  view.zoom(point, 0.5f);
  const Vec2f pixel = pixelOf(view.camera(size), point);
  EXPECT_NEAR(pixel.x, 500, 0.01f);
  EXPECT_NEAR(pixel.y, 100, 0.01f);
  EXPECT_NEAR(view.distance(), 0.5f * before, 1e-4f);
  EXPECT_NEAR(length(point - view.position()), 0.5f * toPoint, 1e-4f);
}

TEST(Viewpoint, ZoomStopsWithinFloatRange) {
  for (const float factor : {0.5f, 2.0f}) {
    Viewpoint view = someViewpoint();
    for (int i = 0; i < 1000; i++) view.zoom({0.5f, 0.25f, -1}, factor);
    EXPECT_GT(view.distance(), 0.0f);
    EXPECT_TRUE(isFinite(view.position()));
    EXPECT_TRUE(isFinite(view.camera(size).direction(0, 0)));
    view.zoom({0.5f, 0.25f, -1}, 1.0f / factor); // zooming back is possible
    EXPECT_NEAR(length(view.direction()), 1.0f, 1e-5f);
  }
}

TEST(Viewpoint, OrbitKeepsItsDistanceAndAvoidsThePoles) {
  Viewpoint view = someViewpoint();
  const Vec3f target = view.camera(size).lookAt();
  const float distance = view.distance();
  for (int i = 0; i < 100; i++) {
    view.orbit(0.3f, 0.4f);
    expectNear(view.camera(size).lookAt(), target);
    ASSERT_NEAR(view.distance(), distance, 1e-3f);
  }
  EXPECT_LT(view.direction().y, 1.0f);
  EXPECT_GT(view.direction().y, 0.99f);
}

TEST(Viewpoint, LookRotatesInPlace) {
  Viewpoint view = someViewpoint();
  const Vec3f direction = view.direction();
  view.look(0.2f, 0.1f);
  expectNear(view.position(), {3, 2, 5});
  EXPECT_GT(dot(view.direction(), cross(direction, Vec3f{0, 1, 0})), 0.0f); // to the right
  EXPECT_GT(view.direction().y, direction.y);
}

TEST(Viewpoint, LookingStraightUpAndDownIsStable) {
  for (const float y : {5.0f, -5.0f}) {
    Viewpoint view(Camera({0, y, 0}, {0, 0, 0}, {0, 1, 0}, 40, size), {0, 1, 0});
    view.pan(10, 10, 5, size);
    view.move(1, 1);
    view.orbit(0.1f, 0.1f);
    EXPECT_TRUE(isFinite(view.position()) && isFinite(view.direction())) << "from y = " << y;
  }
}

/* --- the window's layout ----------------------------------------------------------------- */

bool overlap(Rectangle a, Rectangle b) {
  return a.x < b.x + b.width && b.x < a.x + a.width && a.y < b.y + b.height && b.y < a.y + a.height;
}

int areaOf(Rectangle r) { return r.width * r.height; }

TEST(Layout, AreasDoNotOverlap) {
  for (const ImageSize window :
       {ImageSize{1024, 768}, {400, 300}, {400, 900}, {600, 400}, {599, 400}, {30, 30}, {1, 1}})
    for (const PanelState panel : {PanelState::Open, PanelState::Folded, PanelState::Hidden})
      for (const bool split : {false, true}) {
        const WindowLayout l = computeLayout(window, panel, split);
        EXPECT_FALSE(overlap(l.panel, l.picture) || overlap(l.captions, l.picture) || overlap(l.captions, l.panel));
        EXPECT_EQ(areaOf(l.panel) + areaOf(l.captions) + areaOf(l.picture), window.width * window.height);
        EXPECT_GE(std::min(l.picture.width, l.picture.height), 1);
        EXPECT_LE(l.picture.x + l.picture.width, window.width);
        EXPECT_LE(l.picture.y + l.picture.height, window.height);
      }
}

TEST(Layout, PictureGetsHalfTheWindowOrAllOfItWithoutThePanel) {
  for (const ImageSize window : {ImageSize{1024, 768}, {600, 400}, {400, 300}}) {
    const int all = window.width * window.height;
    EXPECT_GE(2 * areaOf(computeLayout(window, PanelState::Open, false).picture), all);
    EXPECT_GE(10 * areaOf(computeLayout(window, PanelState::Folded, false).picture), 9 * all);
    EXPECT_EQ(areaOf(computeLayout(window, PanelState::Hidden, true).picture), all);
  }
  EXPECT_EQ(computeLayout({1024, 768}, PanelState::Open, true).captions.x, panelWidth);
}

/* --- pictures ---------------------------------------------------------------------------- */

class Pictures : public testing::Test {
protected:
  Pictures() {
    BuildSettings settings;
    settings.level = 4;
    grid.emplace(model, Representation{RepresentationKind::Grid}, settings);
    coarse.emplace(model, Representation{RepresentationKind::CLeaf}, settings);
    camera.emplace(chooseCamera("full", model, *grid, {96, 64}, 1));
  }

  static Model cube() {
    SceneSettings settings;
    settings.scene = "cube";
    std::string warnings;
    return loadScene(settings, warnings);
  }

  const Model model = cube();
  std::optional<BuiltScene> grid, coarse;
  std::optional<Camera> camera;
};

TEST_F(Pictures, CountAllRaysAndTheirHits) {
  Picture picture(*camera, {Pane(&*grid)}, {});
  picture.addSample();
  const std::vector<SurfaceHit> hits = traceClosest(*grid, primaryRays(*camera), 1);
  const auto isHit = [](const SurfaceHit& hit) { return hit.hit(); };
  const PaneReport& report = picture.reports().at(0);
  EXPECT_EQ(report.rays, 96u * 64u);
  EXPECT_EQ(report.hits, size_t(std::count_if(hits.begin(), hits.end(), isHit)));
  EXPECT_LT(report.hits, report.rays);
  EXPECT_GT(report.hits, 0u);
  EXPECT_DOUBLE_EQ(report.mrays() * report.seconds, 96 * 64 * 1e-6);
  EXPECT_DOUBLE_EQ(report.mhits(), report.mrays() * double(report.hits) / double(report.rays));
}

TEST_F(Pictures, HaveTheSameErrorsAsOtherPrograms) {
  PictureSettings settings;
  settings.mode = PictureMode::Error;
  Picture picture(*camera, {Pane(&*coarse, &*grid)}, settings);
  picture.addSample();
  const std::vector<Ray> rays = primaryRays(*camera);
  const HitErrors errors =
      compareHits(traceClosest(*grid, rays, 1), traceClosest(*coarse, rays, 1), camera->footprint(), coarse->layout());
  const PaneReport& report = picture.reports().at(0);
  EXPECT_GT(report.p99, report.median);
  EXPECT_EQ(report.median, errors.median);
  EXPECT_EQ(report.p99, errors.p99);
  EXPECT_EQ(report.falseHits, errors.falseHits);
  EXPECT_EQ(report.misses, errors.misses);
}

TEST_F(Pictures, AccumulateSamplesAndKeepTheFiguresOfTheFirst) {
  PictureSettings settings;
  settings.samples = 4;
  Picture picture(*camera, {Pane(&*coarse)}, settings);
  picture.addSample();
  const std::vector<uint8_t> first = picture.image().rgb;
  const double seconds = picture.reports().at(0).seconds;
  for (int samples = 2; samples <= 4; samples++) {
    EXPECT_FALSE(picture.isComplete());
    picture.addSample();
    EXPECT_EQ(picture.samples(), samples);
  }
  EXPECT_TRUE(picture.isComplete());
  EXPECT_NE(picture.image().rgb, first);
  EXPECT_EQ(picture.reports().size(), 1u);
  EXPECT_EQ(picture.reports()[0].seconds, seconds);
}

TEST_F(Pictures, UseOneRayIfHitsHaveNoMean) {
  for (const PictureMode mode : allPictureModes) {
    PictureSettings settings;
    settings.mode = mode;
    settings.samples = 4;
    EXPECT_EQ(Picture(*camera, {Pane(&*coarse, &*grid)}, settings).wantedSamples(),
              mode == PictureMode::Shading ? 4 : 1);
  }
}

/* A pixel that is half white and half black is brighter than the mean of the encoded values. */
TEST_F(Pictures, AverageLinearColor) {
  PictureSettings settings;
  settings.samples = 3;
  const Image image = renderPicture(*camera, {Pane(&*grid)}, settings);
  const HitShader shader(camera->direction(48, 32), settings.up);
  std::vector<Vec3f> sums(96 * 64);
  for (int i = 0; i < 3; i++) {
    const std::vector<Ray> rays = primaryRays(*camera, sampleOffset(i));
    const std::vector<SurfaceHit> hits = traceClosest(*grid, rays, 1);
    for (size_t k = 0; k < rays.size(); k++)
      sums[k] += hits[k].hit() ? shader.color(rays[k], hits[k]) : backgroundColor(float(k / 96) / 64.0f);
  }
  Image expected({96, 64});
  for (size_t k = 0; k < sums.size(); k++) expected.set(k, (1.0f / 3.0f) * sums[k]);
  EXPECT_EQ(image.rgb, expected.rgb);
}

/* --- opened files ------------------------------------------------------------------------ */

TEST(OpenedFiles, CageReplacesTheSceneAndItsMap) {
  SceneSettings current;
  current.scene = "trex";
  current.rough = true;
  current.amplitude = 0.1f;
  current.threads = 3;
  const SceneSettings opened = openFiles({"a/body.OBJ"}, current);
  EXPECT_EQ(opened.scene, "");
  EXPECT_EQ(opened.cagePath, "a/body.OBJ");
  EXPECT_EQ(opened.heightPath, "");
  EXPECT_FALSE(opened.rough);
  EXPECT_FALSE(opened.amplitude);
  EXPECT_EQ(opened.threads, 3);
  validateScene(opened);
}

TEST(OpenedFiles, MapIsAppliedToTheCurrentCage) {
  SceneSettings current;
  current.cagePath = "body.obj";
  current.heightPath = "old.png";
  current.amplitude = 0.02f;
  const SceneSettings opened = openFiles({"new.exr"}, current);
  EXPECT_EQ(opened.cagePath, "body.obj");
  EXPECT_EQ(opened.heightPath, "new.exr");
  EXPECT_EQ(opened.amplitude, 0.02f);
}

TEST(OpenedFiles, CageWithoutAMapResetsMapOptions) {
  SceneSettings current;
  current.cagePath = "body.obj";
  current.heightPath = "body.exr";
  current.mapValues = MapValues::TangentVectors;
  current.midLevel = 0.25f;
  current.channel = "r";
  current.repeat = {2, 2};
  current.mapScale = 3.0f;
  current.up = "z";
  const SceneSettings alone = openFiles({"head.obj"}, current);
  validateScene(alone);
  EXPECT_EQ(alone.heightPath, "");
  EXPECT_EQ(alone.up, "z");
  const SceneSettings both = openFiles({"head.obj", "head.exr"}, current);
  EXPECT_EQ(both.mapValues, MapValues::TangentVectors);
  EXPECT_EQ(both.mapScale, 3.0f);
}

TEST(OpenedFiles, AnotherCageHasNoLaterTimeSteps) {
  SceneSettings current;
  current.cagePath = "body.obj";
  current.cageEnds = {"end.obj"};
  EXPECT_EQ(openFiles({"skin.png"}, current).cageEnds.size(), 1u);
  EXPECT_TRUE(openFiles({"head.obj"}, current).cageEnds.empty());
}

TEST(OpenedFiles, CageAndMapAreAcceptedInAnyOrder) {
  for (const auto& files : {std::vector<std::string>{"body.obj", "skin.tif"}, {"skin.tif", "body.obj"}}) {
    const SceneSettings opened = openFiles(files, {});
    EXPECT_EQ(opened.cagePath, "body.obj");
    EXPECT_EQ(opened.heightPath, "skin.tif");
    validateScene(opened);
  }
}

TEST(OpenedFiles, CompressedSurfacesHaveNoModel) {
  SceneSettings trex;
  trex.scene = "trex";
  trex.amplitude = 0.01f;
  trex.threads = 3;
  const SceneSettings saved = openFiles({"a/Herd.CBVH"}, trex);
  EXPECT_EQ(saved.savedPath, "a/Herd.CBVH");
  EXPECT_TRUE(saved.scene.empty() && saved.cagePath.empty() && !saved.amplitude);
  EXPECT_EQ(saved.threads, 3);
  EXPECT_THROW(openFiles({"skin.png"}, saved), Error);
  EXPECT_THROW(validateScene(saved), Error);
  const SceneSettings next = openFiles({"head.obj"}, saved);
  EXPECT_EQ(next.cagePath, "head.obj");
  EXPECT_TRUE(next.savedPath.empty());
}

TEST(OpenedFiles, MeshesReplaceTheModel) {
  SceneSettings trex;
  trex.scene = "trex";
  for (const char* path : {"scan.ply", "part.STL", "car.gltf", "car.glb"}) {
    const SceneSettings mesh = openFiles({path}, trex);
    EXPECT_EQ(mesh.meshPath, path);
    EXPECT_TRUE(mesh.scene.empty() && mesh.cagePath.empty());
    validateScene(mesh);
    EXPECT_TRUE(openFiles({"head.obj"}, mesh).meshPath.empty());
    EXPECT_THROW(openFiles({path, "skin.png"}, {}), Error);
    SceneSettings named;
    named.up = "z";
    applyFileArguments({path}, named);
    EXPECT_EQ(named.meshPath, path);
    EXPECT_EQ(named.up, "z");
    EXPECT_THROW(applyFileArguments({path}, trex), Error);
  }
}

TEST(OpenedFiles, IncompatibleFilesAreRejected) {
  SceneSettings trex;
  trex.scene = "trex";
  EXPECT_THROW(openFiles({"skin.png"}, {}), Error);
  EXPECT_THROW(openFiles({"a.obj", "b.cbvh"}, {}), Error);
  EXPECT_THROW(openFiles({"a.cbvh", "b.cbvh"}, {}), Error);
  EXPECT_THROW(openFiles({"skin.png"}, trex), Error);
  EXPECT_THROW(openFiles({"a.obj", "b.obj"}, {}), Error);
  EXPECT_THROW(openFiles({"a.obj", "b.png", "c.png"}, {}), Error);
}

/* --- the worker -------------------------------------------------------------------------- */

void untilCancelled() {
  for (;;) {
    throwIfCanceled();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

TEST(Worker, ReportsThePhaseOfItsWork) {
  Worker worker;
  worker.reportProgress();
  EXPECT_FALSE(worker.progress());
  std::atomic<int> step{0};
  worker.start("loading", [&] {
    const auto waitFor = [&](int n) {
      while (step < n) std::this_thread::yield();
    };
    {
      Phase phase("skin");
      phase.update(0.25);
      step = 1;
      waitFor(2);
    }
    step = 3;
    waitFor(4);
  });
  const auto reached = [&](int n) {
    while (step < n) std::this_thread::yield();
    return worker.progress().value();
  };
  const Worker::Progress within = reached(1);
  step = 2;
  const Worker::Progress after = reached(3);
  step = 4;
  worker.join();
  EXPECT_EQ(within.work, "loading");
  EXPECT_EQ(within.phase, "skin");
  EXPECT_EQ(within.fraction, 0.25);
  EXPECT_EQ(after.phase, "");
  EXPECT_FALSE(worker.progress());
}

TEST(Worker, CanBeStoppedAndRestarted) {
  Worker worker;
  worker.start("endless", untilCancelled);
  worker.cancel();
  EXPECT_EQ(worker.progress()->work, "stopping: endless");
  EXPECT_THROW(worker.join(), Canceled);
  EXPECT_FALSE(cancelRequested());
  bool done = false;
  worker.start("short", [&] {
    throwIfCanceled();
    done = true;
  });
  worker.join();
  EXPECT_TRUE(done);
}

TEST(Worker, DiscardsResultsOfCanceledWork) {
  Worker worker;
  worker.start("short", [] {});
  worker.wait();
  worker.cancel();
  EXPECT_THROW(worker.join(), Canceled);
}

TEST(Worker, ForwardsErrors) {
  Worker worker;
  worker.start("failing", [] { throw Error("no such file"); });
  EXPECT_THROW(worker.join(), Error);
  EXPECT_FALSE(worker.hasTask());
}

TEST(Worker, StopsOnDestruction) {
  {
    Worker worker;
    worker.start("endless", untilCancelled);
  }
  EXPECT_FALSE(cancelRequested());
}

}} // namespace programs::test
