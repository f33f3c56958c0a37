// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* Every call of every fallible Vulkan function fails in turn. Errors name the failed operation, nothing leaks, and
 * existing objects continue to work. */

#include "faults_fixture.h"

#include "kernels/cbvh/backend/flat_scene.h"
#include "support/irregular_mesh.h"

#include <vulkan/vulkan.h>

namespace programs::test { namespace {

// --- every call fails in turn ------------------------------------------------------------------

TEST_F(VulkanFaults, OpeningADeviceDoesNotLeak) {
  device.reset();
  expectAll(failEverything([&] { return bool(open(vulkan->handles)); }),
            {"CreateCommandPool", "CreatePipelineLayout", "CreatePipelineCache", "GetPipelineCacheData"});
}

class VulkanUploadFaults : public VulkanFaults, public testing::WithParamInterface<bool> {};

INSTANTIATE_TEST_SUITE_P(Memory, VulkanUploadFaults, testing::Values(false, true),
                         [](const testing::TestParamInfo<bool>& info) {
                           return info.param ? "OfADiscreteDevice" : "OfTheHost";
                         });

TEST_P(VulkanUploadFaults, UploadingASceneDoesNotLeak) {
  faults->isDiscrete = GetParam();
  reopen();
  Scene scene(embree);
  SmallScene instanced(embree);
  attach(scene, newInstance(embree, instanced, 0));
  attach(scene, newTriangle(embree, 2));
  rtcCommitScene(scene);
  std::vector<RTCVulkanMemory> memories = {RTC_VULKAN_MEMORY_COPY};
  if (vulkan->handles.hasHostImport) memories.push_back(RTC_VULKAN_MEMORY_IMPORT);
  for (RTCVulkanMemory memory : memories) {
    SCOPED_TRACE(testing::Message() << "memory " << int(memory));
    const std::vector<std::string> called = failEverything([&] {
      const VulkanScene uploaded = newVulkanScene(device, scene, memory);
      EXPECT_TRUE(isHit(intersect(scene, raysFromAbove()[0]))) << "the CPU scene still works";
      return uploaded != nullptr;
    });
    expectAll(called, {"AllocateMemory", "CreateBuffer", "BindBufferMemory", "MapMemory"});
    if (memory == RTC_VULKAN_MEMORY_IMPORT) expectAll(called, {"GetMemoryHostPointerPropertiesEXT"});
    if (GetParam())
      expectAll(called, {"AllocateCommandBuffers", "BeginCommandBuffer", "EndCommandBuffer", "CreateFence",
                         "QueueSubmit", "WaitForFences"});
  }
}

// An application traces in pipelines of its own: compute shaders, ray tracing pipelines, fragment shaders. It cannot
// know what the library wrote, so the library's barriers reach all of them. Uploads are copies on a discrete device.
TEST_F(VulkanFaults, UploadsAreVisibleToAllShadersOfTheApplication) {
  faults->isDiscrete = true;
  reopen();
  SmallScene scene(embree);
  size_t copies = 0, structures = 0;
  faults->onBarrier = [&](const VkMemoryBarrier& barrier, VkPipelineStageFlags to) {
    const bool isOfCopy = barrier.srcAccessMask == VK_ACCESS_TRANSFER_WRITE_BIT,
               isOfStructure = barrier.srcAccessMask == VK_ACCESS_ACCELERATION_STRUCTURE_WRITE_BIT_KHR;
    (isOfCopy ? copies : structures) += isOfCopy || isOfStructure;
    EXPECT_TRUE(!(isOfCopy || isOfStructure) || (to & VK_PIPELINE_STAGE_ALL_COMMANDS_BIT)) << "stages " << to;
    EXPECT_TRUE(!isOfCopy || (barrier.dstAccessMask & VK_ACCESS_MEMORY_READ_BIT)) << barrier.dstAccessMask;
  };
  EXPECT_TRUE(newVulkanScene(device, scene, RTC_VULKAN_MEMORY_COPY)) << embree.message;
  EXPECT_GT(copies, 0u);
  if (vulkan->handles.hasRayQuery) {
    EXPECT_TRUE(newQueryScene(device, scene)) << embree.message;
    EXPECT_GT(structures, 0u);
  }
  faults->onBarrier = nullptr;
}

// Traces rays of a scene. The rays remain unchanged if it fails.
template<typename Ray>
std::function<bool()> tracing(const VulkanScene& scene, const std::vector<Ray>& rays,
                              const std::vector<Ray>& expected) {
  return [&] {
    std::vector<Ray> traced = rays;
    RTCVulkanTraceTimes times = {sizeof(times), -1, -1, -1};
    const bool done = trace(scene.get(), traced, &times);
    EXPECT_TRUE(areSame(traced, done ? expected : rays));
    EXPECT_EQ(times.traceSeconds >= 0, done);
    return done;
  };
}

class VulkanTraceFaults : public VulkanUploadFaults {};

INSTANTIATE_TEST_SUITE_P(Memory, VulkanTraceFaults, testing::Values(false, true),
                         [](const testing::TestParamInfo<bool>& info) {
                           return info.param ? "OfADiscreteDevice" : "OfTheHost";
                         });

TEST_P(VulkanTraceFaults, TracingDoesNotLeakAndKeepsRaysUnchanged) {
  faults->isDiscrete = GetParam();
  reopen();
  SmallScene scene(embree);
  const VulkanScene uploaded = newVulkanScene(device, scene);
  ASSERT_TRUE(uploaded) << embree.message;

  const std::vector<RTCRayHit> rays = raysFromAbove();
  std::vector<RTCRayHit> hits = rays;
  std::vector<RTCRay> shadowRays = withoutHits(rays), occluded = shadowRays;
  ASSERT_TRUE(trace(uploaded.get(), hits) && trace(uploaded.get(), occluded)) << embree.message;
  expectAsOnTheCPU(scene, rays, hits);

  const char* const functions[] = {
      "AllocateMemory",         "CreateBuffer",       "BindBufferMemory", "MapMemory",
      "AllocateCommandBuffers", "BeginCommandBuffer", "EndCommandBuffer", "CreateFence",
      "CreateQueryPool",        "QueueSubmit",        "WaitForFences",    "GetQueryPoolResults"};
  const std::vector<std::string> expected(std::begin(functions), std::end(functions));
  expectAll(failEverything(tracing(uploaded, rays, hits)), expected);
  expectAll(failEverything(tracing(uploaded, shadowRays, occluded)), expected);
  rtcSetVulkanSceneRaySorting(uploaded.get(), true);
  std::vector<RTCRayHit> sorted = rays;
  ASSERT_TRUE(trace(uploaded.get(), sorted)) << embree.message;
  EXPECT_TRUE(areSame(sorted, hits));
  expectAll(failEverything(tracing(uploaded, rays, hits)), expected);
}

// Each shader: those for tracing, and those for sorting rays beforehand.
TEST_F(VulkanFaults, FailedShadersAreCreatedByTheNextTrace) {
  SmallScene scene(embree, RTC_COMPRESSION_CVOXEL);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  for (const char* function : {"CreateShaderModule", "CreateComputePipelines"}) {
    SCOPED_TRACE(function);
    const VulkanScene uploaded = newVulkanScene(device, scene);
    ASSERT_TRUE(uploaded) << embree.message;
    rtcSetVulkanSceneRaySorting(uploaded.get(), true);
    const Fault fault = faultOf(function);
    const std::map<std::string, size_t> before = faults->live();
    std::vector<RTCRayHit> traced = rays;
    size_t made = 0;
    // each attempt creates one more shader, and then the next one fails
    for (bool done = false; !done && made < 100; made += !done) {
      for (unsigned n : {1, 1, 2}) {
        faults->fail(function, n, fault.result);
        done = trace(uploaded.get(), traced);
        if (done) break;
        EXPECT_TRUE(faults->hasFailed());
        EXPECT_EQ(embree.takeError(), fault.error) << embree.message;
        EXPECT_TRUE(containsInOrder(embree.message, {"shader", fault.name}));
        EXPECT_TRUE(areSame(traced, rays));
        std::map<std::string, size_t> expected = before;
        if (made + n > 1) expected["pipeline"] = made + n - 1;
        EXPECT_EQ(faults->live(), expected);
      }
    }
    EXPECT_EQ(made, 4u) << "the fifth was the last";
    expectAsOnTheCPU(scene, rays, traced);
    reopen();
  }
}

// --- memory --------------------------------------------------------------------------------------

// The message contains the size of the failed call and the name of the buffer.
TEST_F(VulkanFaults, FailedAllocationsAreReported) {
  SmallScene scene(embree);
  std::vector<std::string> messages;
  auto collect = [&](const std::function<bool()>& step) {
    for (unsigned n = 1;; n++) {
      faults->fail("AllocateMemory", n, VK_ERROR_OUT_OF_DEVICE_MEMORY);
      const bool done = step();
      faults->failNothing();
      if (done) return;
      EXPECT_EQ(embree.takeError(), RTC_ERROR_OUT_OF_MEMORY);
      messages.push_back(embree.message);
    }
  };
  collect([&] { return newVulkanScene(device, scene, RTC_VULKAN_MEMORY_COPY) != nullptr; });
  if (vulkan->handles.hasHostImport)
    collect([&] { return newVulkanScene(device, scene, RTC_VULKAN_MEMORY_IMPORT) != nullptr; });
  const VulkanScene uploaded = newVulkanScene(device, scene);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  collect([&] {
    std::vector<RTCRayHit> traced = rays;
    return trace(uploaded.get(), traced);
  });
  for (const char* what : {"blocks", "rays"})
    EXPECT_TRUE(std::any_of(messages.begin(), messages.end(), [&](const std::string& message) {
      return has(message, std::string(" bytes for ") + what);
    })) << what;
}

// NVIDIA's driver rejects imports of mapped files.
TEST_F(VulkanFaults, BlocksThatTheDriverDoesNotImportAreCopied) {
  if (!vulkan->handles.hasHostImport) GTEST_SKIP() << "the driver does not import memory";
  const SmallScene scene(embree, RTC_COMPRESSION_CVERT);
  faults->fail("GetMemoryHostPointerPropertiesEXT", 1, VK_ERROR_OUT_OF_DEVICE_MEMORY);
  EXPECT_FALSE(newVulkanScene(device, scene, RTC_VULKAN_MEMORY_IMPORT));
  EXPECT_EQ(embree.takeError(), RTC_ERROR_OUT_OF_MEMORY);
  for (const char* part : {"importing", "VK_ERROR_OUT_OF_DEVICE_MEMORY", "RTC_VULKAN_MEMORY_AUTO"})
    EXPECT_TRUE(has(embree.message, part)) << embree.message;

  faults->fail("GetMemoryHostPointerPropertiesEXT", 1, VK_ERROR_OUT_OF_DEVICE_MEMORY);
  const VulkanScene uploaded = newVulkanScene(device, scene, RTC_VULKAN_MEMORY_AUTO);
  faults->failNothing();
  ASSERT_TRUE(uploaded) << embree.message;
  RTCVulkanSceneStatistics statistics;
  rtcGetVulkanSceneStatistics(uploaded.get(), &statistics);
  EXPECT_EQ(statistics.importedBytes, 0u);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  expectAsOnTheCPU(scene, rays, traceAll(uploaded.get(), rays));
}

TEST_F(VulkanFaults, AllocationLimitIsReportedWithItsValue) {
  size_t limit = 100000;
  faults->onProperties2 = [&](VkPhysicalDeviceProperties2& properties) {
    for (VkBaseOutStructure* p = (VkBaseOutStructure*)&properties; p; p = p->pNext)
      if (p->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES)
        ((VkPhysicalDeviceMaintenance3Properties*)p)->maxMemoryAllocationSize = limit;
  };
  reopen();
  {
    SmallScene scene(embree);
    const VulkanScene uploaded = newVulkanScene(device, scene, RTC_VULKAN_MEMORY_COPY);
    ASSERT_TRUE(uploaded) << embree.message;
    std::vector<RTCRayHit> rays(limit / sizeof(RTCRayHit) + 1, raysFromAbove()[0]);
    EXPECT_FALSE(trace(uploaded.get(), rays));
    EXPECT_EQ(embree.takeError(), RTC_ERROR_OUT_OF_MEMORY);
    const std::string size = " " + std::to_string(rays.size() * sizeof(RTCRayHit)) + " bytes";
    EXPECT_TRUE(containsInOrder(embree.message, {"rays", size, "maxMemoryAllocationSize", " 100000 bytes"}));
    rays.pop_back();
    EXPECT_TRUE(trace(uploaded.get(), rays)) << embree.message;
  }

  limit = 100;
  reopen();
  SmallScene scene(embree);
  EXPECT_FALSE(newVulkanScene(device, scene, RTC_VULKAN_MEMORY_COPY));
  EXPECT_EQ(embree.takeError(), RTC_ERROR_OUT_OF_MEMORY);
  EXPECT_TRUE(containsInOrder(embree.message, {"blocks", "maxMemoryAllocationSize", " 100 bytes"}));
}

TEST_F(VulkanFaults, BlocksUseSeveralBuffersIfTheLimitIsLow) {
  SurfaceSettings settings = smallSurface(RTC_COMPRESSION_CGRID);
  settings.rate = 64;
  settings.frameLevel = 2;
  SurfaceScene scene(embree, sheetCage(8), settings);
  std::vector<RTCRayHit> rays;
  Random random(211);
  for (int i = 0; i < 200; i++)
    rays.push_back(makeRay({float(random.uniform(-1, 1)), float(random.uniform(-1, 1)), 3}, {0.01f, 0.02f, -1}));
  faults->onProperties2 = [&](VkPhysicalDeviceProperties2& properties) {
    for (VkBaseOutStructure* p = (VkBaseOutStructure*)&properties; p; p = p->pNext)
      if (p->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES)
        ((VkPhysicalDeviceMaintenance3Properties*)p)->maxMemoryAllocationSize = 1 << 20;
  };
  for (const bool isDiscrete : {false, true})
    for (RTCVulkanMemory memory : {RTC_VULKAN_MEMORY_COPY, RTC_VULKAN_MEMORY_IMPORT}) {
      if (memory == RTC_VULKAN_MEMORY_IMPORT && !vulkan->handles.hasHostImport) continue;
      SCOPED_TRACE(testing::Message() << "memory " << int(memory) << ", discrete " << isDiscrete);
      faults->isDiscrete = isDiscrete;
      reopen();
      const size_t before = faults->live()["buffer"];
      const VulkanScene uploaded = newVulkanScene(device, scene, memory);
      ASSERT_TRUE(uploaded) << embree.message;
      EXPECT_GE(faults->live()["buffer"], before + 4) << "3 MB of blocks in pieces of 1 MiB, and their descriptions";
      const std::vector<RTCRayHit> traced = traceAll(uploaded.get(), rays);
      expectAsOnTheCPU(scene, rays, traced);
    }
}

// Bits of cVERT and of tiles are read in words, which may extend beyond the last byte of a block. kernels/cbvh
// allocates memory there, and the next page is imported if necessary. In scenes of all sizes, some blocks end at the
// end of a page.
TEST_F(VulkanFaults, PaddingAfterBlocksIsImportedWithThem) {
  if (!vulkan->handles.hasHostImport) GTEST_SKIP() << "the driver does not import memory";
  struct Range {
    const char* begin;
    size_t bytes;
  };
  std::vector<Range> ranges;
  faults->onAllocation = [&](const VkMemoryAllocateInfo& info) {
    for (const VkBaseInStructure* p = (const VkBaseInStructure*)&info; p; p = p->pNext)
      if (p->sType == VK_STRUCTURE_TYPE_IMPORT_MEMORY_HOST_POINTER_INFO_EXT)
        ranges.push_back(
            {(const char*)((const VkImportMemoryHostPointerInfoEXT*)p)->pHostPointer, size_t(info.allocationSize)});
  };
  const size_t readPadding = 16;
  size_t overEndOfPage[3] = {0, 0, 0}; // of blocks of grids, of mesh blocks, and of tiles
  Random random(241);
  for (int i = 0; i < 1000; i++) {
    Scene scene(embree);
    Displacement displacement;
    if (i % 4 == 3) {
      const DicedMesh sheet = meshOf(dicedSheet(1, 17 + unsigned(random.below(24))), QuadOrder::Rows, random);
      attach(scene, newMesh(embree, irregularTriangles(sheet, random), RTC_COMPRESSION_CVERT));
    } else {
      SurfaceSettings settings = smallSurface(i % 4 == 2 ? RTC_COMPRESSION_CTILE : RTC_COMPRESSION_CVERT);
      displacement.amplitude = float(random.uniform(0, 0.1));
      settings.displacement = &displacement;
      settings.rate = float(1 + random.below(12));
      addSurface(embree, scene, sheetCage(1 + unsigned(random.below(6))), settings);
    }
    rtcCommitScene(scene);
    ranges.clear();
    ASSERT_TRUE(newVulkanScene(device, scene, RTC_VULKAN_MEMORY_IMPORT)) << embree.message;
    const embree::cbvh::FlatScene* flat = rtcFlattenScene(scene, embree::cbvh::flatSceneVersion);
    ASSERT_TRUE(flat) << embree.message;
    for (size_t b = 0; b < flat->numBlocks; b++) {
      const char* begin = (const char*)flat->blocks[b].data;
      const char* end = begin + flat->blocks[b].bytes;
      EXPECT_TRUE(
          std::any_of(ranges.begin(), ranges.end(),
                      [&](const Range& r) { return begin >= r.begin && end + readPadding <= r.begin + r.bytes; }))
          << "scene " << i << ", block " << b;
      const uint32_t type = flat->blocks[b].type;
      const int sort = type == embree::cbvh::meshBlockReferenceType                       ? 1
                       : type == embree::cbvh::blockReferenceType(embree::cbvh::kindTile) ? 2
                                                                                          : 0;
      overEndOfPage[sort] += (size_t(end) - 1) / 4096 != (size_t(end) + readPadding - 1) / 4096;
    }
    rtcReleaseFlatScene(flat);
  }
  for (size_t count : overEndOfPage) EXPECT_GT(count, 0u);
}

// --- lost devices ------------------------------------------------------------------------------

TEST_F(VulkanFaults, DeviceLostAtTheStartOfATraceIsAnError) {
  SmallScene scene(embree);
  VulkanScene uploaded = newVulkanScene(device, scene);
  ASSERT_TRUE(uploaded) << embree.message;
  std::vector<RTCRayHit> rays = raysFromAbove();
  faults->fail("QueueSubmit", 1, VK_ERROR_DEVICE_LOST, Faults::INSTEAD, true);
  EXPECT_EQ(rtcStartVulkanIntersect(uploaded.get(), rays.data(), rays.size()), nullptr);
  EXPECT_EQ(embree.takeError(), RTC_ERROR_UNKNOWN);
  EXPECT_TRUE(containsInOrder(embree.message, {"VK_ERROR_DEVICE_LOST", "release"}));
  EXPECT_TRUE(isHit(intersect(scene, rays[0]))) << "the CPU scene still works";
}

TEST_F(VulkanFaults, DeviceLostDuringATraceKeepsRaysUnchanged) {
  SmallScene scene(embree);
  VulkanScene uploaded = newVulkanScene(device, scene);
  ASSERT_TRUE(uploaded) << embree.message;
  const std::vector<RTCRayHit> rays = raysFromAbove();
  std::vector<RTCRayHit> traced = rays;
  std::vector<RTCRay> occluded = withoutHits(rays);
  const RTCVulkanTrace one = rtcStartVulkanIntersect(uploaded.get(), rays.data(), rays.size());
  const RTCVulkanTrace other = rtcStartVulkanOccluded(uploaded.get(), occluded.data(), occluded.size());
  ASSERT_TRUE(one && other) << embree.message;
  faults->fail("WaitForFences", 1, VK_ERROR_DEVICE_LOST, Faults::AFTER, true);
  RTCVulkanTraceTimes times = {sizeof(times), -1, -1, -1};
  EXPECT_FALSE(rtcFinishVulkanTrace(one, traced.data(), &times));
  EXPECT_EQ(embree.takeError(), RTC_ERROR_UNKNOWN);
  EXPECT_TRUE(containsInOrder(embree.message, {"VK_ERROR_DEVICE_LOST", "release"}));
  EXPECT_TRUE(areSame(traced, rays));
  EXPECT_EQ(times.traceSeconds, -1);
  EXPECT_FALSE(rtcFinishVulkanTrace(other, occluded.data(), nullptr));
  EXPECT_EQ(embree.takeError(), RTC_ERROR_UNKNOWN);
  EXPECT_TRUE(areSame(occluded, withoutHits(rays)));
  EXPECT_TRUE(isHit(intersect(scene, rays[0]))) << "the CPU scene still works";
  faults->fail("GetPipelineCacheData", 1, VK_ERROR_DEVICE_LOST, Faults::INSTEAD, true);
}

TEST_F(VulkanFaults, TraceOfALostDeviceIsDone) {
  SmallScene scene(embree);
  VulkanScene uploaded = newVulkanScene(device, scene);
  std::vector<RTCRayHit> rays = raysFromAbove();
  const RTCVulkanTrace trace = rtcStartVulkanIntersect(uploaded.get(), rays.data(), rays.size());
  ASSERT_TRUE(trace) << embree.message;
  faults->fail("GetFenceStatus", 1, VK_ERROR_DEVICE_LOST, Faults::INSTEAD, true);
  EXPECT_TRUE(rtcIsVulkanTraceDone(trace));
  faults->fail("WaitForFences", 1, VK_ERROR_DEVICE_LOST, Faults::AFTER, true);
  EXPECT_FALSE(rtcFinishVulkanTrace(trace, rays.data(), nullptr));
  EXPECT_EQ(embree.takeError(), RTC_ERROR_UNKNOWN);
}

TEST_F(VulkanFaults, DeviceLostDuringAnUploadIsAnError) {
  faults->isDiscrete = true;
  reopen();
  SmallScene scene(embree);
  for (const auto& [function, when] :
       {std::make_pair("QueueSubmit", Faults::INSTEAD), std::make_pair("WaitForFences", Faults::AFTER)}) {
    faults->fail(function, 1, VK_ERROR_DEVICE_LOST, when, true);
    EXPECT_FALSE(newVulkanScene(device, scene));
    EXPECT_EQ(embree.takeError(), RTC_ERROR_UNKNOWN);
    EXPECT_TRUE(containsInOrder(embree.message, {"VK_ERROR_DEVICE_LOST", "release"}));
  }
}

// The trace holds the last references to all objects, including the RTCDevice that receives the error.
TEST_F(VulkanFaults, ErrorOfATraceThatOutlivesAllObjectsIsReported) {
  using Error = std::pair<RTCError, std::string>;
  Error error;
  {
    const RTCDevice other = rtcNewDevice(nullptr);
    rtcSetDeviceErrorFunction(
        other, [](void* to, RTCError code, const char* text) { *(Error*)to = {code, text}; }, &error);
    RTCVulkanTrace trace;
    std::vector<RTCRayHit> rays = raysFromAbove();
    {
      const VulkanDevice mine(rtcNewVulkanDeviceFromHandles(other, &vulkan->handles));
      const SmallScene scene(other);
      const VulkanScene uploaded = newVulkanScene(mine, scene);
      ASSERT_TRUE(uploaded) << error.second;
      trace = rtcStartVulkanIntersect(uploaded.get(), rays.data(), rays.size());
      ASSERT_TRUE(trace) << error.second;
    }
    rtcReleaseDevice(other);
    faults->fail("WaitForFences", 1, VK_ERROR_DEVICE_LOST, Faults::AFTER, true);
    EXPECT_FALSE(rtcFinishVulkanTrace(trace, rays.data(), nullptr));
  }
  EXPECT_EQ(error.first, RTC_ERROR_UNKNOWN);
  EXPECT_TRUE(containsInOrder(error.second, {"VK_ERROR_DEVICE_LOST", "release"}));
}

}} // namespace programs::test
