// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* libembree3_vulkan with validation: arguments, and lifetimes of objects. */

#include "api_fixture.h"
#include "recorded_trace.h"

#include <cstddef>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <cctype>
#include <functional>

namespace programs::test { namespace {

// --- arguments ---------------------------------------------------------------------------------

TEST_F(VulkanAPI, NullArgumentsAreReportedByName) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  ASSERT_TRUE(uploaded) << embree.message;

  EXPECT_EQ(rtcNewVulkanDeviceFromHandles(embree, nullptr), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"handles"});
  EXPECT_EQ(rtcNewVulkanScene(device.get(), nullptr, nullptr), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"scene"});
  rtcGetVulkanDeviceInfo(device.get(), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"info"});
  rtcGetVulkanDeviceHandles(device.get(), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"handles"});
  rtcGetVulkanSceneStatistics(uploaded.get(), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"statistics"});
  EXPECT_EQ(rtcStartVulkanIntersect(uploaded.get(), nullptr, 1), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"rays"});
  EXPECT_EQ(rtcStartVulkanOccluded(uploaded.get(), nullptr, 1), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"rays"});
  EXPECT_FALSE(rtcRecordVulkanIntersect(uploaded.get(), nullptr, 16, 1));
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"commands"});
}

// Checks that precede opening a device require neither a device nor a loader.
TEST(VulkanStructSizes, AreCheckedBeforeALoaderIsOpened) {
  Device embree;
  const auto expectWrong = [&](const char* name, size_t size, size_t accepted) {
    EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_ARGUMENT);
    EXPECT_TRUE(containsInOrder(embree.message, {name, " " + std::to_string(size), " " + std::to_string(accepted)}));
  };
  RTCVulkanDeviceInfo info = RTCVulkanDeviceInfo();
  RTCVulkanDeviceHandles handles = RTCVulkanDeviceHandles();
  EXPECT_EQ(info.structSize, sizeof(info));
  EXPECT_EQ(handles.structSize, sizeof(handles));
  for (size_t wrong : {size_t(0), size_t(8), sizeof(handles) - 1, sizeof(handles) + 1, size_t(4104), ~size_t(0)}) {
    info.structSize = handles.structSize = wrong;
    EXPECT_EQ(rtcGetVulkanDevices(embree, &info, 1), 0u);
    expectWrong("RTCVulkanDeviceInfo", wrong, sizeof(info));
    EXPECT_EQ(rtcNewVulkanDeviceFromHandles(embree, &handles), nullptr);
    expectWrong("RTCVulkanDeviceHandles", wrong, sizeof(handles));
  }
  struct {
    RTCVulkanDeviceHandles known;
    size_t more;
  } newer = {RTCVulkanDeviceHandles(), 1};
  newer.known.structSize = sizeof(newer);
  EXPECT_EQ(rtcNewVulkanDeviceFromHandles(embree, &newer.known), nullptr);
  expectWrong("RTCVulkanDeviceHandles", sizeof(newer), sizeof(handles));
  newer.more = 0;
  EXPECT_EQ(rtcNewVulkanDeviceFromHandles(embree, &newer.known), nullptr);
  EXPECT_EQ(embree.takeError(), RTC_ERROR_INVALID_ARGUMENT);
  EXPECT_TRUE(has(embree.message, "getInstanceProcAddr")) << embree.message;
}

// A struct of a newer application. more: members of a later version.
template<typename T>
struct Newer {
  T known = T();
  size_t more[2] = {7, 7};
  Newer() { known.structSize = sizeof(*this); }
};

TEST_F(VulkanAPI, StructsOfNewerApplicationsAreFilledWithZeros) {
  const SmallScene scene(embree);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  Newer<RTCVulkanSceneArguments> arguments;
  EXPECT_EQ(rtcNewVulkanScene(device.get(), scene, &arguments.known), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"RTCVulkanSceneArguments", " " + std::to_string(sizeof(arguments)),
                                           "byte " + std::to_string(sizeof(arguments.known))});
  arguments.more[0] = arguments.more[1] = 0;
  const VulkanScene uploaded(rtcNewVulkanScene(device.get(), scene, &arguments.known));
  ASSERT_TRUE(uploaded) << embree.message;

  const auto expectFilled = [](const auto& written) {
    EXPECT_EQ(written.known.structSize, sizeof(written));
    EXPECT_EQ(written.more[0], 0u);
    EXPECT_EQ(written.more[1], 0u);
  };
  Newer<RTCVulkanDeviceInfo> info;
  rtcGetVulkanDeviceInfo(device.get(), &info.known);
  expectFilled(info);
  EXPECT_EQ(info.known.name, vulkan->name);
  Newer<RTCVulkanDeviceHandles> handles;
  rtcGetVulkanDeviceHandles(device.get(), &handles.known);
  expectFilled(handles);
  EXPECT_EQ(handles.known.queue, vulkan->handles.queue);
  Newer<RTCVulkanSceneStatistics> statistics;
  rtcGetVulkanSceneStatistics(uploaded.get(), &statistics.known);
  expectFilled(statistics);
  EXPECT_GT(statistics.known.deviceBytes + statistics.known.importedBytes, 0u);
  Newer<RTCVulkanTraceTimes> times;
  times.known.traceSeconds = -1;
  const RTCVulkanTrace trace = rtcStartVulkanIntersect(uploaded.get(), rays.data(), rays.size());
  EXPECT_TRUE(rtcFinishVulkanTrace(trace, nullptr, &times.known));
  expectFilled(times);
  EXPECT_GE(times.known.traceSeconds, 0);
  expectNoError();
}

TEST_F(VulkanAPI, StructsOfTheWrongSizeAreReportedAndNotWritten) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  std::vector<RTCRayHit> rays = raysFromAbove();
  const std::vector<RTCRayHit> before = rays;
  RTCVulkanSceneArguments arguments = RTCVulkanSceneArguments();
  RTCVulkanDeviceInfo info = RTCVulkanDeviceInfo();
  RTCVulkanDeviceHandles handles = RTCVulkanDeviceHandles();
  RTCVulkanSceneStatistics statistics = RTCVulkanSceneStatistics();
  RTCVulkanTraceTimes times = {0, -1, -1, -1};
  arguments.structSize = info.structSize = handles.structSize = statistics.structSize = 0;
  EXPECT_EQ(rtcNewVulkanScene(device.get(), scene, &arguments), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"RTCVulkanSceneArguments", "structSize 0"});
  rtcGetVulkanDeviceInfo(device.get(), &info);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"RTCVulkanDeviceInfo", "structSize 0"});
  EXPECT_STREQ(info.name, "");
  rtcGetVulkanDeviceHandles(device.get(), &handles);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"RTCVulkanDeviceHandles", "structSize 0"});
  EXPECT_FALSE(handles.device);
  rtcGetVulkanSceneStatistics(uploaded.get(), &statistics);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"RTCVulkanSceneStatistics", "structSize 0"});
  EXPECT_EQ(statistics.deviceBytes, 0u);
  const RTCVulkanTrace trace = rtcStartVulkanIntersect(uploaded.get(), rays.data(), rays.size());
  EXPECT_FALSE(rtcFinishVulkanTrace(trace, rays.data(), &times));
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"RTCVulkanTraceTimes", "structSize 0"});
  EXPECT_EQ(times.traceSeconds, -1);
  EXPECT_TRUE(areSame(rays, before));
}

// structSize is the stride of an array's entries.
TEST_F(VulkanAPI, ListsOfDevicesUseTheApplicationsEntrySize) {
  const unsigned count = rtcGetVulkanDevices(embree, nullptr, 0);
  ASSERT_GE(count, 1u);
  std::vector<RTCVulkanDeviceInfo> infos(count);
  ASSERT_EQ(rtcGetVulkanDevices(embree, infos.data(), count), count);
  std::vector<Newer<RTCVulkanDeviceInfo>> newer(count + 1);
  ASSERT_EQ(rtcGetVulkanDevices(embree, &newer[0].known, count), count);
  for (unsigned i = 0; i < count; i++) {
    EXPECT_STREQ(newer[i].known.name, infos[i].name);
    EXPECT_EQ(newer[i].known.memoryBytes, infos[i].memoryBytes);
    EXPECT_EQ(newer[i].known.structSize, sizeof(newer[i]));
    EXPECT_EQ(newer[i].more[0], 0u);
  }
  EXPECT_STREQ(newer[count].known.name, "");
  EXPECT_EQ(newer[count].more[0], 7u);
  expectNoError();
  if (count < 2) return;
  infos[1].structSize = 0;
  infos[0].name[0] = '\0';
  EXPECT_EQ(rtcGetVulkanDevices(embree, infos.data(), count), 0u);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"RTCVulkanDeviceInfo", "structSize 0", "infos[1]"});
  EXPECT_STREQ(infos[0].name, "");
}

TEST_F(VulkanAPI, ArgumentsOfRayOrdersAreChecked) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  RecordedTrace recorded(vulkan->handles);
  const size_t most = size_t(1) << 27;
  EXPECT_EQ(rtcGetVulkanRayOrderBytes(0), 0u);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
  EXPECT_GT(rtcGetVulkanRayOrderBytes(most), 16 * most);
  EXPECT_EQ(rtcGetVulkanRayOrderBytes(most + 1), 0u);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  recorded.record([&](VkCommandBuffer commands) {
    const struct {
      VkCommandBuffer commands;
      VkDeviceAddress rays;
      size_t stride, count;
      VkDeviceAddress order;
      std::vector<std::string> message;
    } wrong[] = {
        {nullptr, 0x1000, 80, 1, 0x2000, {"commands"}},
        {commands, 0x1004, 80, 1, 0x2000, {"rays", "4100"}},
        {commands, 0x1000, 80, 1, 0x2004, {"order", "8196"}},
        {commands, 0, 80, 1, 0x2000, {"rays", " 0"}},
        {commands, 0x1000, 80, 1, 0, {"order", " 0"}},
        {commands, 0x1000, 24, 1, 0x2000, {"stride 24"}},
        {commands, 0x1000, 50, 1, 0x2000, {"stride 50"}},
        {commands, 0x1000, 80, most + 1, 0x2000, {std::to_string(most + 1)}},
        {commands, 0x1000, 4096, most / 16, 0x2000, {"stride 4096", std::to_string(most / 16), " 2048 bytes"}}};
    for (const auto& w : wrong) {
      EXPECT_FALSE(rtcRecordVulkanRayOrder(uploaded.get(), w.commands, w.rays, w.stride, w.count, w.order));
      expectError(RTC_ERROR_INVALID_ARGUMENT, w.message);
    }
    EXPECT_FALSE(rtcRecordVulkanIntersectInOrder(uploaded.get(), commands, 0x1000, 1, 0x2004));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {"order", "8196"});
    EXPECT_FALSE(rtcRecordVulkanOccludedInOrder(uploaded.get(), commands, 0x1000, most + 1, 0x2000));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {std::to_string(most + 1)});
    EXPECT_TRUE(rtcRecordVulkanRayOrder(uploaded.get(), commands, 0, 80, 0, 0))
        << "zero rays are valid: " << embree.message;
  });
}

// More rays than in one dispatch of a device. Nothing is submitted: the layer checks limits when commands are recorded.
TEST_F(VulkanAPI, ManyRaysAreRecordedWithinDeviceLimits) {
  Scene scene(embree);
  attach(scene, newTriangle(embree, 0));
  rtcCommitScene(scene);
  const VulkanScene uploaded = upload(scene);
  RecordedTrace recorded(vulkan->handles);
  recorded.record([&](VkCommandBuffer commands) {
    const size_t most = size_t(1) << 27;
    EXPECT_TRUE(rtcRecordVulkanIntersect(uploaded.get(), commands, 0x1000, size_t(1) << 32)) << embree.message;
    EXPECT_TRUE(rtcRecordVulkanOccluded(uploaded.get(), commands, 0x1000, size_t(1) << 32)) << embree.message;
    EXPECT_TRUE(rtcRecordVulkanIntersectInOrder(uploaded.get(), commands, 0x1000, most, 0x2000)) << embree.message;
    if (!rtcRecordVulkanRayOrder(uploaded.get(), commands, 0x1000, sizeof(RTCRayHit), most, 0x2000))
      expectError(RTC_ERROR_INVALID_ARGUMENT, {std::to_string(most), "maxComputeWorkGroupCount"});
    EXPECT_TRUE(rtcRecordVulkanRayOrder(uploaded.get(), commands, 0x1000, sizeof(RTCRayHit), size_t(1) << 20, 0x2000))
        << embree.message;
  });
}

// Their size in bytes would overflow 64 bits.
TEST_F(VulkanAPI, MoreRaysThanFitIntoMemoryAreAnError) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  const size_t closest = SIZE_MAX / sizeof(RTCRayHit) + 2, any = SIZE_MAX / sizeof(RTCRay) + 2;
  EXPECT_EQ(rtcStartVulkanIntersect(uploaded.get(), rays.data(), closest), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"count " + std::to_string(closest)});
  EXPECT_EQ(rtcStartVulkanOccluded(uploaded.get(), &rays[0].ray, any), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"count " + std::to_string(any)});
}

// Without an object there is no RTCDevice: the error belongs to the thread.
TEST_F(VulkanAPI, NullObjectsAreAnErrorOfTheThread) {
  RTCVulkanDeviceInfo info;
  RTCVulkanDeviceHandles handles;
  RTCVulkanSceneStatistics statistics;
  const SmallScene scene(embree);
  RTCRayHit ray = raysFromAbove()[0];
  const VkCommandBuffer commands = VkCommandBuffer(size_t(16));
  const std::function<void()> calls[] = {
      [] { rtcRetainVulkanDevice(nullptr); },
      [] { rtcReleaseVulkanDevice(nullptr); },
      [&] { rtcGetVulkanDeviceInfo(nullptr, &info); },
      [&] { rtcGetVulkanDeviceHandles(nullptr, &handles); },
      [&] { EXPECT_EQ(rtcNewVulkanScene(nullptr, scene, nullptr), nullptr); },
      [] { rtcRetainVulkanScene(nullptr); },
      [] { rtcReleaseVulkanScene(nullptr); },
      [] { EXPECT_EQ(rtcGetVulkanSceneAddress(nullptr), 0u); },
      [] { EXPECT_EQ(rtcGetVulkanSceneLeafKinds(nullptr), 0u); },
      [&] { rtcGetVulkanSceneStatistics(nullptr, &statistics); },
      [&] { EXPECT_FALSE(rtcRecordVulkanIntersect(nullptr, commands, 16, 1)); },
      [&] { EXPECT_FALSE(rtcRecordVulkanOccluded(nullptr, commands, 16, 1)); },
      [&] { EXPECT_EQ(rtcStartVulkanIntersect(nullptr, &ray, 1), nullptr); },
      [&] { EXPECT_EQ(rtcStartVulkanOccluded(nullptr, &ray.ray, 1), nullptr); },
      [&] { EXPECT_FALSE(rtcRecordVulkanRayOrder(nullptr, commands, 16, 80, 1, 16)); },
      [&] { EXPECT_FALSE(rtcRecordVulkanIntersectInOrder(nullptr, commands, 16, 1, 16)); },
      [&] { EXPECT_FALSE(rtcRecordVulkanOccludedInOrder(nullptr, commands, 16, 1, 16)); },
      [] { rtcSetVulkanSceneRaySorting(nullptr, true); },
      [] { EXPECT_FALSE(rtcIsVulkanTraceDone(nullptr)); },
      [] { EXPECT_FALSE(rtcFinishVulkanTrace(nullptr, nullptr, nullptr)); }};
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
  for (size_t i = 0; i < std::size(calls); i++) {
    calls[i]();
    EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT) << "call " << i;
  }
}

TEST_F(VulkanAPI, DeviceWithoutRTCDeviceReportsToTheThread) {
  const VulkanDevice mine(rtcNewVulkanDeviceFromHandles(nullptr, &vulkan->handles));
  ASSERT_TRUE(mine);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
  Scene scene(embree);
  attach(scene, newTriangle(embree, 1));
  EXPECT_FALSE(newVulkanScene(mine, scene));
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_OPERATION);
  expectError(RTC_ERROR_INVALID_OPERATION, {"committed"});
  rtcCommitScene(scene);
  const VulkanScene uploaded = newVulkanScene(mine, scene);
  ASSERT_TRUE(uploaded);
  EXPECT_EQ(rtcStartVulkanIntersect(uploaded.get(), nullptr, 1), nullptr);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  expectAsOnTheCPU(scene, rays, traceAll(uploaded.get(), rays));
}

TEST_F(VulkanAPI, MissingOrInvalidHandlesAreReported) {
  const std::pair<const char*, void (*)(RTCVulkanDeviceHandles&)> removals[] = {
      {"getInstanceProcAddr", [](RTCVulkanDeviceHandles& h) { h.getInstanceProcAddr = nullptr; }},
      {"instance", [](RTCVulkanDeviceHandles& h) { h.instance = nullptr; }},
      {"physicalDevice", [](RTCVulkanDeviceHandles& h) { h.physicalDevice = nullptr; }},
      {"device", [](RTCVulkanDeviceHandles& h) { h.device = nullptr; }},
      {"queue", [](RTCVulkanDeviceHandles& h) { h.queue = nullptr; }},
      {"queueFamily 7000", [](RTCVulkanDeviceHandles& h) { h.queueFamily = 7000; }}};
  for (const auto& removal : removals) {
    RTCVulkanDeviceHandles handles = vulkan->handles;
    removal.second(handles);
    EXPECT_FALSE(open(handles));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {removal.first});
  }
}

TEST_F(VulkanAPI, NullAndUnalignedRayAddressesAreErrors) {
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  RecordedTrace recorded(vulkan->handles);
  recorded.record([&](VkCommandBuffer commands) {
    EXPECT_FALSE(rtcRecordVulkanIntersect(uploaded.get(), commands, 0x1008, 1));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {"rays", "4104", " 16"});
    EXPECT_FALSE(rtcRecordVulkanOccluded(uploaded.get(), commands, 0x1001, 1));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {"rays", "4097", " 16"});
    EXPECT_FALSE(rtcRecordVulkanIntersect(uploaded.get(), commands, 0, 1));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {"rays"});
  });
}

TEST_F(VulkanAPI, InvalidMemoryKindsAreErrors) {
  const SmallScene scene(embree);
  for (int memory : {-1, 3, 1000}) {
    RTCVulkanSceneArguments args;
    std::memcpy(&args.memory, &memory, sizeof(memory)); // possible in C
    EXPECT_EQ(rtcNewVulkanScene(device.get(), scene, &args), nullptr);
    expectError(RTC_ERROR_INVALID_ARGUMENT, {"memory", std::to_string(memory)});
  }
}

TEST_F(VulkanAPI, DevicesAreFoundByIndexAndByPartOfTheirName) {
  const unsigned count = rtcGetVulkanDevices(embree, nullptr, 0);
  ASSERT_GE(count, 1u);
  std::vector<RTCVulkanDeviceInfo> infos(count + 1);
  std::memset((void*)&infos[count], 0x5A, sizeof(infos[count]));
  const RTCVulkanDeviceInfo untouched = infos[count];
  EXPECT_EQ(rtcGetVulkanDevices(embree, infos.data(), count + 1), count);
  EXPECT_EQ(std::memcmp(&infos[count], &untouched, sizeof(untouched)), 0);
  EXPECT_EQ(rtcGetVulkanDevices(nullptr, nullptr, 0), count) << "device may be NULL";

  for (unsigned i = 0; i < count; i++)
    for (const std::string& selector : {std::to_string(count), std::to_string(count + 100), std::string("4294967296"),
                                        std::string("no such device")}) {
      EXPECT_EQ(rtcNewVulkanDevice(embree, selector.c_str()), nullptr);
      expectError(RTC_ERROR_INVALID_ARGUMENT, {"'" + selector + "'", std::to_string(i) + " " + infos[i].name});
    }

  for (unsigned i = 0; i < count; i++) {
    if (infos[i].unsupportedReason[0]) continue;
    const auto upper = [](std::string text) {
      std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::toupper(c)); });
      return text;
    };
    const std::string part = upper(infos[i].name).substr(1, 5);
    for (const std::string& selector : {std::to_string(i), std::string(infos[i].name), part}) {
      const VulkanDevice opened(rtcNewVulkanDevice(embree, selector.c_str()));
      ASSERT_TRUE(opened) << selector << ": " << embree.message;
      RTCVulkanDeviceInfo info;
      rtcGetVulkanDeviceInfo(opened.get(), &info);
      const size_t members = offsetof(RTCVulkanDeviceInfo, hasRayQuery) + sizeof(info.hasRayQuery); // without padding
      EXPECT_TRUE(selector != std::to_string(i) || !std::memcmp(&info, &infos[i], members));
      EXPECT_TRUE(has(upper(info.name), upper(selector)) || selector == std::to_string(i)) << info.name;
      RTCVulkanDeviceHandles handles;
      rtcGetVulkanDeviceHandles(opened.get(), &handles);
      EXPECT_TRUE(handles.getInstanceProcAddr && handles.instance && handles.physicalDevice && handles.device &&
                  handles.queue);
    }
  }
  for (const char* selector : {"", static_cast<const char*>(nullptr)}) {
    const VulkanDevice opened(rtcNewVulkanDevice(embree, selector));
    EXPECT_TRUE(opened) << embree.message;
  }
}

TEST_F(VulkanAPI, DeviceReportsGivenHandles) {
  RTCVulkanDeviceHandles handles;
  rtcGetVulkanDeviceHandles(device.get(), &handles);
  EXPECT_EQ(handles.device, vulkan->handles.device);
  EXPECT_EQ(handles.queue, vulkan->handles.queue);
  EXPECT_EQ(handles.hasFloat64, vulkan->handles.hasFloat64);
  RTCVulkanDeviceInfo info;
  rtcGetVulkanDeviceInfo(device.get(), &info);
  EXPECT_EQ(info.name, vulkan->name);
  EXPECT_STREQ(info.unsupportedReason, "");
  EXPECT_NE(std::string(info.driver), "");
  EXPECT_GT(info.memoryBytes, 0u);
}

// --- lifetimes -----------------------------------------------------------------------------------

TEST_F(VulkanAPI, ObjectsKeepTheirDependenciesAlive) {
  const std::vector<RTCRayHit> rays = raysFromAbove();
  std::vector<RTCRayHit> traced = rays, expected = rays;
  RTCVulkanTrace trace;
  {
    RTCVulkanScene kept;
    {
      const VulkanDevice other = open(vulkan->handles);
      const SmallScene scene(embree);
      for (RTCRayHit& ray : expected) ray = intersect(scene, ray);
      const VulkanScene uploaded = newVulkanScene(other, scene); // imported if possible
      ASSERT_TRUE(uploaded) << embree.message;
      rtcRetainVulkanScene(uploaded.get());
      kept = uploaded.get();
    }
    EXPECT_TRUE(programs::test::trace(kept, traced)) << "device and scene are released: " << embree.message;
    for (size_t i = 0; i < rays.size(); i++) EXPECT_EQ(traced[i].hit.geomID, expected[i].hit.geomID);
    trace = rtcStartVulkanIntersect(kept, rays.data(), rays.size());
    ASSERT_TRUE(trace) << embree.message;
    rtcReleaseVulkanScene(kept);
  }
  std::vector<RTCRayHit> again = rays;
  EXPECT_TRUE(rtcFinishVulkanTrace(trace, again.data(), nullptr)) << embree.message;
  EXPECT_TRUE(areSame(again, traced));
}

TEST_F(VulkanAPI, DeviceLivesUntilItIsReleased) {
  RTCVulkanDevice other = open(vulkan->handles).release();
  rtcRetainVulkanDevice(other);
  rtcReleaseVulkanDevice(other);
  RTCVulkanDeviceInfo info;
  rtcGetVulkanDeviceInfo(other, &info);
  EXPECT_EQ(info.name, vulkan->name);
  rtcReleaseVulkanDevice(other);
  expectNoError();
}

TEST_F(VulkanAPI, UploadedSceneDoesNotChangeWithItsSource) {
  Scene scene(embree);
  const unsigned id = attach(scene, newTriangle(embree, 1));
  rtcCommitScene(scene);
  const VulkanScene before = upload(scene, RTC_VULKAN_MEMORY_COPY);
  const RTCGeometry geometry = rtcGetGeometry(scene, id);
  float* z = (float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  for (int i = 0; i < 3; i++) z[3 * i + 2] = 2;
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry);
  EXPECT_FALSE(upload(scene));
  expectError(RTC_ERROR_INVALID_OPERATION, {"committed"});
  rtcCommitScene(scene);
  const VulkanScene after = upload(scene, RTC_VULKAN_MEMORY_COPY);
  const std::vector<RTCRayHit> rays = {makeRay({-0.5f, -0.5f, 5}, {0, 0, -1})};
  EXPECT_EQ(traceAll(before.get(), rays)[0].ray.tfar, 4);
  EXPECT_EQ(traceAll(after.get(), rays)[0].ray.tfar, 3);
}

}} // namespace programs::test
