// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Scenes that a Vulkan device accepts, scenes that it rejects with a reason, and the location of their memory. */

#include "api_fixture.h"

#include <tbb/task_group.h>

#include <functional>
#include <limits>

namespace programs::test { namespace {

using VulkanScenes = VulkanAPI;

// --- rejected scenes -------------------------------------------------------------------------------

TEST_F(VulkanScenes, UncommittedScenesAreErrors) {
  Scene scene(embree);
  attach(scene, newTriangle(embree, 0));
  EXPECT_FALSE(upload(scene));
  expectError(RTC_ERROR_INVALID_OPERATION, {"committed"});
  rtcCommitScene(scene);
  EXPECT_TRUE(upload(scene)) << embree.message;
  attach(scene, newTriangle(embree, 1));
  EXPECT_FALSE(upload(scene));
  expectError(RTC_ERROR_INVALID_OPERATION, {"committed"});
}

// The scene may belong to another RTCDevice.
TEST_F(VulkanScenes, ErrorReachesDevicesOfSceneAndVulkanDevice) {
  Device other;
  Scene scene(other);
  attach(scene, newTriangle(other, 1));
  EXPECT_FALSE(upload(scene));
  expectError(RTC_ERROR_INVALID_OPERATION, {"scene"});
  EXPECT_EQ(other.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_TRUE(has(other.message, "committed")) << other.message;
  rtcCommitScene(scene);
  const VulkanScene uploaded = upload(scene);
  ASSERT_TRUE(uploaded) << embree.message;
  const std::vector<RTCRayHit> rays = raysFromAbove();
  expectAsOnTheCPU(scene, rays, traceAll(uploaded.get(), rays));
}

struct RefusedGeometry {
  const char* name;
  std::vector<std::string> message;
  std::function<RTCGeometry(RTCDevice)> make; // committed; NULL if this build does not support it
};

template<typename Fill>
RTCGeometry newGeometry(RTCDevice device, RTCGeometryType type, const Fill& fill) {
  RTCGeometry geometry = rtcNewGeometry(device, type);
  if (!geometry) return nullptr;
  fill(geometry);
  rtcCommitGeometry(geometry);
  return geometry;
}

const std::vector<Vec> square = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};

std::vector<RefusedGeometry> refusedGeometries() {
  return {{"quad mesh",
           {"quad mesh"},
           [](RTCDevice device) {
             return newGeometry(device, RTC_GEOMETRY_TYPE_QUAD, [](RTCGeometry g) {
               setBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, square);
               setBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4,
                         std::vector<std::array<unsigned, 4>>{{0, 1, 2, 3}});
             });
           }},
          {"grid mesh",
           {"grid mesh"},
           [](RTCDevice device) {
             return newGeometry(device, RTC_GEOMETRY_TYPE_GRID, [](RTCGeometry g) {
               setBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                         std::vector<Vec>{square[0], square[1], square[3], square[2]});
               setBuffer(g, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, std::vector<RTCGrid>{{0, 2, 2, 2}});
             });
           }},
          {"user geometry",
           {"user geometry"},
           [](RTCDevice device) {
             return newGeometry(device, RTC_GEOMETRY_TYPE_USER, [](RTCGeometry g) {
               rtcSetGeometryUserPrimitiveCount(g, 1);
               rtcSetGeometryBoundsFunction(
                   g, [](const RTCBoundsFunctionArguments* args) { *args->bounds_o = {-1, -1, -1, 0, 1, 1, 1, 0}; },
                   nullptr);
               rtcSetGeometryIntersectFunction(g, [](const RTCIntersectFunctionNArguments*) {});
               rtcSetGeometryOccludedFunction(g, [](const RTCOccludedFunctionNArguments*) {});
             });
           }},
          {"curve",
           {"curves"},
           [](RTCDevice device) -> RTCGeometry {
             if (!rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_CURVE_GEOMETRY_SUPPORTED)) return nullptr;
             return newGeometry(device, RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE, [](RTCGeometry g) {
               setBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                         std::vector<std::array<float, 4>>{{-1, 0, 0, 0.1f}, {1, 0, 0, 0.1f}});
               setBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, std::vector<unsigned>{0});
             });
           }},
          {"points",
           {"points"},
           [](RTCDevice device) -> RTCGeometry {
             if (!rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_POINT_GEOMETRY_SUPPORTED)) return nullptr;
             return newGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT, [](RTCGeometry g) {
               setBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4,
                         std::vector<std::array<float, 4>>{{0, 0, 0, 0.1f}});
             });
           }},
          {"triangle mesh with motion blur",
           {"triangle mesh", "motion", "2 time steps"},
           [](RTCDevice device) { return newTriangle(device, 0, 2); }},
          {"surface with motion blur",
           {"surface", "motion", "2 time steps"},
           [](RTCDevice device) {
             SurfaceSettings settings = smallSurface(RTC_COMPRESSION_NONE);
             settings.timeSteps = 2;
             return newSurface(device, sheetCage(1), settings);
           }},
          {"triangle mesh with an intersection filter",
           {"filter"},
           [](RTCDevice device) {
             const RTCGeometry g = newTriangle(device, 0);
             rtcSetGeometryIntersectFilterFunction(g, [](const RTCFilterFunctionNArguments*) {});
             rtcCommitGeometry(g);
             return g;
           }},
          {"surface with an occlusion filter", {"filter"}, [](RTCDevice device) {
             const RTCGeometry g = newSurface(device, sheetCage(1), smallSurface(RTC_COMPRESSION_CLEAF));
             rtcSetGeometryOccludedFilterFunction(g, [](const RTCFilterFunctionNArguments*) {});
             rtcCommitGeometry(g);
             return g;
           }}};
}

TEST_F(VulkanScenes, UnsupportedGeometriesAreReportedUnlessDisabled) {
  for (const RefusedGeometry& refused : refusedGeometries()) {
    SCOPED_TRACE(refused.name);
    const RTCGeometry geometry = refused.make(embree);
    if (!geometry) {
      expectNoError();
      continue;
    }
    Scene scene(embree);
    rtcAttachGeometryByID(scene, geometry, 3); // lower IDs have no geometry
    attach(scene, newTriangle(embree, 1));
    rtcCommitScene(scene);
    expectNoError();
    EXPECT_FALSE(upload(scene));
    expectError(RTC_ERROR_INVALID_OPERATION, {"geometry 3 "});
    expectMessage(refused.message);

    Scene above(embree);
    attach(above, newTriangle(embree, 2));
    attach(above, newInstance(embree, scene, 0));
    rtcCommitScene(above);
    EXPECT_FALSE(upload(above));
    expectError(RTC_ERROR_INVALID_OPERATION, {"geometry 3 ", "instanced"});
    expectMessage(refused.message);

    rtcDisableGeometry(geometry);
    rtcCommitScene(scene);
    rtcCommitGeometry(rtcGetGeometry(above, 1));
    rtcCommitScene(above);
    for (RTCScene each : {RTCScene(scene), RTCScene(above)}) {
      const VulkanScene uploaded = upload(each);
      ASSERT_TRUE(uploaded) << embree.message;
    }
    rtcReleaseGeometry(geometry);
  }
}

TEST_F(VulkanScenes, UnsupportedInstancesAreReported) {
  Scene triangle(embree), instance(embree), above(embree), cyclic(embree), moving(embree);
  attach(triangle, newTriangle(embree, 0));
  rtcCommitScene(triangle);
  attach(instance, newTriangle(embree, 1));
  attach(instance, newInstance(embree, triangle, 0));
  rtcCommitScene(instance);
  EXPECT_TRUE(upload(instance)) << embree.message;
  attach(above, newInstance(embree, instance, 0));
  rtcCommitScene(above);
  EXPECT_FALSE(upload(above));
  expectError(RTC_ERROR_INVALID_OPERATION, {"geometry 1 ", "instanced", "instance", "RTC_MAX_INSTANCE_LEVEL_COUNT"});
  attach(cyclic, newTriangle(embree, 0));
  attach(cyclic, newInstance(embree, cyclic, 0));
  rtcCommitScene(cyclic);
  EXPECT_FALSE(upload(cyclic));
  expectError(RTC_ERROR_INVALID_OPERATION, {"geometry 1 ", " own ", "RTC_MAX_INSTANCE_LEVEL_COUNT"});
  rtcDetachGeometry(cyclic, 1); // the scene no longer retains itself
  attach(moving, newTriangle(embree, 1));
  attach(moving, newInstance(embree, triangle, 0, 2));
  rtcCommitScene(moving);
  EXPECT_TRUE(upload(moving)) << embree.message;
  RTCQuaternionDecomposition turn;
  rtcInitQuaternionDecomposition(&turn);
  for (unsigned t : {0u, 1u}) rtcSetGeometryTransformQuaternion(rtcGetGeometry(moving, 1), t, &turn);
  rtcCommitGeometry(rtcGetGeometry(moving, 1));
  rtcCommitScene(moving);
  EXPECT_FALSE(upload(moving));
  expectError(RTC_ERROR_INVALID_OPERATION, {"geometry 1 ", "motion", "2 time steps", "linear"});
  rtcDisableGeometry(rtcGetGeometry(moving, 1));
  rtcCommitScene(moving);
  EXPECT_TRUE(upload(moving)) << embree.message;
}

// Nothing leaks.
TEST_F(VulkanScenes, UploadWithoutMemoryOfEmbreeIsAnError) {
  struct Limit {
    ssize_t live = 0, most = std::numeric_limits<ssize_t>::max();
    static bool monitor(void* self, ssize_t bytes, bool) {
      Limit& limit = *(Limit*)self;
      if (bytes > 0 && limit.live + bytes > limit.most) return false;
      limit.live += bytes;
      return true;
    }
  } limit;
  Device other("threads=1");
  rtcSetDeviceMemoryMonitorFunction(other, Limit::monitor, &limit);
  {
    Scene scene(other);
    attach(scene, newTriangle(other, 0));
    rtcCommitScene(scene);
    limit.most = limit.live;
    const VulkanDevice mine(rtcNewVulkanDeviceFromHandles(other, &vulkan->handles));
    EXPECT_FALSE(newVulkanScene(mine, scene));
    EXPECT_EQ(other.takeError(), RTC_ERROR_OUT_OF_MEMORY) << other.message;
    limit.most = std::numeric_limits<ssize_t>::max();
    EXPECT_TRUE(newVulkanScene(mine, scene)) << other.message;
  }
}

// Other failures of Embree's builder keep their code and text, for example if the application cancels the task in which
// it uploads a scene.
TEST_F(VulkanScenes, UploadInACanceledTaskIsNotAboutMemory) {
  const unsigned count = 50000;
  RTCGeometry geometry = rtcNewGeometry(embree, RTC_GEOMETRY_TYPE_TRIANGLE);
  float* vertices =
      (float*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, 3 * count);
  unsigned* indices =
      (unsigned*)rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count);
  Random random(5);
  for (unsigned i = 0; i < 3 * count; i++) {
    for (int k = 0; k < 3; k++) vertices[3 * i + k] = float(random.uniform());
    indices[i] = i;
  }
  rtcCommitGeometry(geometry);
  Scene scene(embree);
  attach(scene, geometry);
  rtcCommitScene(scene);
  tbb::task_group group;
  bool isUploaded = true;
  group.run_and_wait([&] {
    group.cancel();
    isUploaded = bool(upload(scene));
  });
  EXPECT_FALSE(isUploaded);
  expectError(RTC_ERROR_UNKNOWN, {"cancel"});
  EXPECT_TRUE(upload(scene)) << embree.message;
}

// --- accepted scenes -------------------------------------------------------------------------------

TEST_F(VulkanScenes, StatisticsReportLocationOfMemory) {
  Scene scene(embree);
  const SmallScene instanced(embree);
  attach(scene, newInstance(embree, instanced, 0));
  attach(scene, newInstance(embree, instanced, 1));
  attach(scene, newTriangle(embree, 3));
  rtcCommitScene(scene);
  RTCVulkanSceneStatistics copied, imported;
  const VulkanScene copy = upload(scene, RTC_VULKAN_MEMORY_COPY);
  ASSERT_TRUE(copy) << embree.message;
  rtcGetVulkanSceneStatistics(copy.get(), &copied);
  EXPECT_EQ(copied.importedBytes, 0u);
  EXPECT_EQ(copied.numInstances, 2u);
  EXPECT_EQ(copied.numGeometries, 5u) << "three, and two of the instanced scene, which is stored once";
  EXPECT_EQ(copied.numBlocks, 4u * 4);
  EXPECT_GT(copied.numNodes, 0u);
  EXPECT_GT(copied.topLevelBytes, 0u);
  EXPECT_GE(copied.deviceBytes, copied.topLevelBytes + statisticsOf(instanced).headerBytes +
                                    statisticsOf(instanced).nodeBytes + statisticsOf(instanced).leafBytes);
  EXPECT_EQ(copied.stackSize % 32, 0u);
  EXPECT_NE(rtcGetVulkanSceneAddress(copy.get()), 0u);
  EXPECT_EQ(rtcGetVulkanSceneAddress(copy.get()) % 16, 0u);
  EXPECT_NE(rtcGetVulkanSceneLeafKinds(copy.get()), 0u);
  if (!vulkan->handles.hasHostImport) return;
  const VulkanScene import = upload(scene, RTC_VULKAN_MEMORY_IMPORT), again = upload(scene, RTC_VULKAN_MEMORY_IMPORT);
  ASSERT_TRUE(import && again) << embree.message;
  rtcGetVulkanSceneStatistics(import.get(), &imported);
  EXPECT_GT(imported.importedBytes, 0u);
  EXPECT_LT(imported.deviceBytes, copied.deviceBytes);
  EXPECT_EQ(imported.numBlocks, copied.numBlocks);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  const std::vector<RTCRayHit> traced = traceAll(copy.get(), rays);
  expectAsOnTheCPU(scene, rays, traced);
  EXPECT_TRUE(areSame(traceAll(import.get(), rays), traced));
  EXPECT_TRUE(areSame(traceAll(again.get(), rays), traced));
}

// The transferred bytes are those of surfaces that the device did not have, and of the scene's tree.
TEST_F(VulkanScenes, BlocksAreTransferredOnceAndAgainOnlyAfterChanges) {
  for (unsigned rate : {16u, 512u}) { // surfaces that share a buffer, and surfaces with their own buffers
    SCOPED_TRACE(testing::Message() << "rate " << rate);
    SurfaceSettings settings = smallSurface(RTC_COMPRESSION_CVERT);
    Displacement displacement;
    settings.rate = float(rate);
    settings.displacement = &displacement;
    std::unique_ptr<Scene> first(new Scene(embree)), second(new Scene(embree));
    const RTCGeometry a = rtcGetGeometry(*first, addSurface(embree, *first, sheetCage(2), settings));
    const RTCGeometry b = rtcGetGeometry(*first, addSurface(embree, *first, sheetCage(3), settings));
    rtcCommitScene(*first);
    rtcAttachGeometryByID(*second, a, 7);
    rtcCommitScene(*second);
    auto sent = [&](const VulkanScene& scene) {
      RTCVulkanSceneStatistics statistics;
      rtcGetVulkanSceneStatistics(scene.get(), &statistics);
      EXPECT_GE(statistics.deviceBytes, statistics.uploadedBytes);
      return statistics.uploadedBytes - statistics.topLevelBytes;
    };
    const std::vector<RTCRayHit> rays = raysFromAbove();
    auto expectHits = [&](const VulkanScene& scene, RTCScene of) {
      expectAsOnTheCPU(of, rays, traceAll(scene.get(), rays));
    };

    VulkanScene all = upload(*first, RTC_VULKAN_MEMORY_COPY);
    ASSERT_TRUE(all) << embree.message;
    auto blockBytes = [](RTCScene scene) {
      const RTCCompressionStatistics s = statisticsOf(scene);
      return s.headerBytes + s.nodeBytes + s.leafBytes;
    };
    const size_t bytes = blockBytes(*first), ofA = blockBytes(*second);
    EXPECT_GE(sent(all), bytes * 9 / 10); // without the padding between blocks on the host
    const size_t ofTheScene = 1024;       // geometries and similar data
    const VulkanScene shared = upload(*second, RTC_VULKAN_MEMORY_COPY), again = upload(*first, RTC_VULKAN_MEMORY_COPY);
    EXPECT_LT(sent(shared), ofTheScene);
    EXPECT_LT(sent(again), ofTheScene);
    expectHits(shared, *second);

    rtcSetGeometryMask(b, 2);
    rtcCommitGeometry(b);
    rtcCommitScene(*first);
    EXPECT_LT(sent(upload(*first, RTC_VULKAN_MEMORY_COPY)), ofTheScene);
    rtcSetGeometryMask(b, ~0u);
    rtcSetGeometryTessellationRate(b, float(rate / 2));
    rtcCommitGeometry(b);
    rtcCommitScene(*first);
    VulkanScene changed = upload(*first, RTC_VULKAN_MEMORY_COPY);
    EXPECT_LT(sent(changed), bytes - ofA);
    EXPECT_GE(sent(changed), (bytes - ofA) / 8);
    all.reset();
    expectHits(changed, *first);
    expectHits(shared, *second);
    changed.reset();
    first.reset(); // a's blocks are still used by the second scene
    expectHits(shared, *second);
  }
}

// A tree contains moving blocks once per time interval, and instanced scenes may contain the surfaces of a scene.
TEST_F(VulkanScenes, RepeatedBlocksAreStoredOnce) {
  SurfaceSettings settings = smallSurface(RTC_COMPRESSION_CVERT);
  settings.timeSteps = 9;
  settings.motion = orbiting;
  Scene moving(embree);
  addSurface(embree, moving, sheetCage(4), settings);
  rtcCommitScene(moving);
  RTCVulkanSceneStatistics statistics;
  const VulkanScene uploaded = upload(moving, RTC_VULKAN_MEMORY_COPY);
  ASSERT_TRUE(uploaded) << embree.message;
  rtcGetVulkanSceneStatistics(uploaded.get(), &statistics);
  EXPECT_EQ(statistics.numBlocks, statisticsOf(moving).numBlocks);
  std::vector<RTCRayHit> rays;
  for (int i = 0; i < 200; i++) {
    const float time = float(i) / 200, a = 2 * float(M_PI) * time;
    rays.push_back(makeRay({3 * std::cos(a), 3 * std::sin(a), 5}, {0.01f, 0.02f, -1}));
    rays.back().ray.time = time;
  }
  expectAsOnTheCPU(moving, rays, traceAll(uploaded.get(), rays));

  settings = smallSurface(RTC_COMPRESSION_CVERT);
  settings.rate = 512; // a buffer of its own
  Scene alone(embree), several(embree);
  const RTCGeometry geometry = rtcGetGeometry(alone, addSurface(embree, alone, sheetCage(2), settings));
  rtcCommitScene(alone);
  rtcAttachGeometry(several, geometry);
  std::vector<std::unique_ptr<Scene>> instanced;
  for (int i = 1; i < 5; i++) {
    instanced.emplace_back(new Scene(embree));
    rtcAttachGeometry(*instanced.back(), geometry);
    rtcCommitScene(*instanced.back());
    attach(several, newInstance(embree, *instanced.back(), float(i)));
  }
  rtcCommitScene(several);
  const RTCCompressionStatistics blocks = statisticsOf(alone);
  const size_t blockBytes = blocks.headerBytes + blocks.nodeBytes + blocks.leafBytes;
  ASSERT_GT(blockBytes, size_t(1) << 20);
  const VulkanScene all = upload(several, RTC_VULKAN_MEMORY_COPY);
  ASSERT_TRUE(all) << embree.message;
  rtcGetVulkanSceneStatistics(all.get(), &statistics);
  EXPECT_LT(statistics.deviceBytes - statistics.topLevelBytes, blockBytes * 3 / 2);
}

// Embree stores grids for a scene without compressed geometry, apart from the grids for scenes with some.
TEST_F(VulkanScenes, ACageOfScenesWithAndWithoutCompressedGeometryMatchesCpu) {
  Displacement below;
  below.offset = {0, 0, -2};
  Scene mixed(embree), plain(embree);
  const SurfaceSettings settings = smallSurface(RTC_COMPRESSION_NONE);
  const RTCGeometry cage = rtcGetGeometry(mixed, addSurface(embree, mixed, sheetCage(2), settings));
  addSurface(embree, mixed, sheetCage(2), displacedSettings(below, RTC_COMPRESSION_CVERT, 8));
  rtcCommitScene(mixed);
  rtcAttachGeometry(plain, cage);
  rtcCommitScene(plain);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  const std::array<RTCScene, 2> orders[] = {{mixed, plain}, {plain, mixed}};
  for (const auto& order : orders) {
    const VulkanScene first = upload(order[0], RTC_VULKAN_MEMORY_COPY),
                      second = upload(order[1], RTC_VULKAN_MEMORY_COPY);
    ASSERT_TRUE(first && second) << embree.message;
    expectAsOnTheCPU(order[0], rays, traceAll(first.get(), rays));
    expectAsOnTheCPU(order[1], rays, traceAll(second.get(), rays));
  }
}

TEST_F(VulkanScenes, BlocksWithoutASceneAreTransferredAgain) {
  const SmallScene scene(embree, RTC_COMPRESSION_CVERT);
  RTCVulkanSceneStatistics before, after;
  VulkanScene uploaded = upload(scene, RTC_VULKAN_MEMORY_COPY);
  rtcGetVulkanSceneStatistics(uploaded.get(), &before);
  uploaded.reset();
  uploaded = upload(scene, RTC_VULKAN_MEMORY_COPY);
  rtcGetVulkanSceneStatistics(uploaded.get(), &after);
  EXPECT_EQ(before.uploadedBytes, after.uploadedBytes);
}

}} // namespace programs::test
