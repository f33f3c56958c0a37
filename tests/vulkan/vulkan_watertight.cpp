// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* No leaks on the device: rays through random sheets, and rays out of closed surfaces at shared vertices and edges.
 * Rays that leave the surface do not hit it again if rays of the CPU do not. */

#include "basics/parallel.h"
#include "building/built_scene.h"
#include "measure/leak_rays.h"
#include "measure/sheet_crossings.h"
#include "programs/view_options.h"
#include "measure/self_shadow.h"
#include "scenes/catalogue.h"
#include "tracing/camera.h"
#include "tracing/ray_sets.h"
#include "tracing/trace_hits.h"
#include "validated_device.h"

#include <stdexcept>

namespace programs::test { namespace {

class VulkanWatertight : public testing::TestWithParam<RTCCompression> {
protected:
  void SetUp() override {
    if (!ValidatedDevice::missing().empty()) GTEST_SKIP() << ValidatedDevice::missing();
  }
};

std::string nameOf(const testing::TestParamInfo<RTCCompression>& info) { return kindName(info.param); }
INSTANTIATE_TEST_SUITE_P(Compression, VulkanWatertight,
                         testing::Values(RTC_COMPRESSION_CVOXEL, RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT,
                                         RTC_COMPRESSION_CTILE),
                         nameOf);

TEST_P(VulkanWatertight, RaysThroughRandomSheetsHit) {
  Device device;
  SheetSettings settings;
  settings.rays = 200000;
  settings.raysPerSheet = 5000;
  settings.seed = 81;
  settings.device = "vulkan";
  const programs::SheetCrossings found = crossSheets(device, GetParam(), settings, 1);
  EXPECT_GT(found.rays, found.gridMisses * 100);
  EXPECT_EQ(found.closest, 0u);
  EXPECT_EQ(found.any, 0u);
  for (const std::string& example : found.examples) ADD_FAILURE() << example;
}

// A closed scene with GRID, and with a representation on the device.
struct ClosedScene {
  static constexpr int level = 5, frameLevel = 2;

  Model model = load();
  BuiltScene grid{model, {RepresentationKind::Grid}, settings("cpu")};
  BuiltScene scene;

  explicit ClosedScene(RTCCompression compression) : scene(model, representation(compression), settings("vulkan")) {}

  static Model load() {
    SceneSettings settings;
    settings.scene = "cube";
    std::string warning;
    return loadScene(settings, warning);
  }
  static Representation representation(RTCCompression compression) {
    // fallback_faces is off: leaves are tested
    for (const Representation& r : parseRepresentations("cvoxel,cleaf-only,cvert,ctile", frameLevel))
      if (r.compression() == compression) return r;
    throw std::logic_error("no such representation");
  }
  static BuildSettings settings(const std::string& device) {
    BuildSettings build;
    build.level = level;
    build.device = device;
    return build;
  }
};

TEST_P(VulkanWatertight, RaysOutOfAClosedSurfaceHit) {
  const ClosedScene closed(GetParam());
  const PatchLayout layout = closed.model.layout(ClosedScene::level);
  const AimPoints points = pickAimPoints({layout, ClosedScene::level, ClosedScene::frameLevel},
                                         tessellate(closed.model, ClosedScene::settings("cpu")), 10000, 83);
  LeakSettings settings;
  settings.rays = 200000;
  settings.thickness = closed.scene.report().distanceFromMesh();
  const LeakCounts counts = countLeaks(closed.grid.handle(), closed.scene.tracer(), points, settings, 1);
  EXPECT_GT(counts.aimed, settings.rays / 4);
  EXPECT_EQ(counts.sceneLeaks.closest, 0u);
  EXPECT_EQ(counts.sceneLeaks.any, 0u);
  EXPECT_EQ(counts.sceneLeaks.through, 0u);
}

// Not more errors than on the CPU: 1 in 1000 of all rays may differ by rounding.
TEST_P(VulkanWatertight, SecondaryRaysMatchCpu) {
  const ClosedScene closed(GetParam());
  const Box3f box = closed.grid.bounds();
  const Vec3f eye = box.upper + 1.5f * (box.upper - box.lower);
  const Camera camera(eye, 0.5f * (box.lower + box.upper), {0, 1, 0}, 30, ImageSize{256, 256});
  const std::vector<Ray> primary = primaryRays(camera);
  const std::vector<SurfaceHit> gridHits = traceClosest(closed.grid, primary, 1),
                                hits = traceClosest(closed.scene, primary, 1);
  ShadowSettings shadows;
  shadows.offset = RayOffset::ofEmbree();
  shadows.raysPerHit = 2;
  const auto compare = [&](const SceneTracer& tracer) {
    return compareShadows({closed.grid.tracer(), gridHits}, {tracer, hits}, {primary, camera.footprint()}, shadows, 1);
  };
  const ShadowComparison onDevice = compare(closed.scene.tracer()),
                         onProcessor = compare(EmbreeTracer(closed.scene.handle()));
  EXPECT_GT(onDevice.rays, 20000u);
  EXPECT_EQ(onDevice.rays, onProcessor.rays);
  const size_t slack = onDevice.rays / 1000;
  EXPECT_LE(onDevice.all.falseOcclusions, onProcessor.all.falseOcclusions + slack);
  EXPECT_LE(onDevice.all.falsePasses, onProcessor.all.falsePasses + slack);
}

}} // namespace programs::test
