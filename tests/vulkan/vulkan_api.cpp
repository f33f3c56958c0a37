// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* libembree3_vulkan as a program sees it: arguments, what keeps what, which scenes are taken, and
 * the ways to trace. All of it under validation. */

#include "recorded_trace.h"
#include "small_scenes.h"

#include <vulkan/vulkan.h>

#include <algorithm>
#include <thread>

namespace cbvh::test {
namespace {

class VulkanAPI : public VulkanTest
{
protected:
  void expectMessage(const std::vector<std::string>& parts)
  {
    for (const std::string& part : parts) EXPECT_TRUE(has(embree.message, part)) << "'" << embree.message << "' has no '" << part << "'";
  }

  void expectError(RTCError code, const std::vector<std::string>& parts)
  {
    EXPECT_EQ(embree.takeError(), code) << embree.message;
    expectMessage(parts);
  }

  void expectNoError() { EXPECT_EQ(embree.takeError(), RTC_ERROR_NONE) << embree.message; }

  VulkanScene upload(RTCScene scene, RTCVulkanMemory memory = RTC_VULKAN_MEMORY_AUTO) { return newVulkanScene(device, scene, memory); }
};

// --- validation itself ---------------------------------------------------------------------------

TEST(Validation, TellsOfWhatIsLeftAndOfWhatIsNotSynchronised)
{
  useCacheFolderOfTests();
  if (const std::string reason = ValidatedDevice::missing(); !reason.empty()) GTEST_SKIP() << reason;
  if (!Validation::isInstalled()) GTEST_SKIP() << "no validation layer";
  ValidatedDevice device;
  const std::vector<RTCRayHit> rays = raysFromAbove();
  {
    RayBuffer from(device.handles, rays.data(), 64), to(device.handles, rays.data(), 64);
    RecordedTrace recorded(device.handles);
    recorded.record([&](VkCommandBuffer commands) {
      for (int i = 0; i < 2; i++) recorded.copy(commands, from, to, 64); // the second writes what the first has written
    });
  }
  VkBufferCreateInfo info = {};
  info.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  info.size = 64;
  info.usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  VkBuffer buffer;
  ASSERT_EQ(vkCreateBuffer(device.handles.device, &info, nullptr, &buffer), VK_SUCCESS);
  std::string said;
  for (const std::string& message : device.destroy()) said += message + "\n";
  EXPECT_TRUE(has(said, "SYNC-HAZARD-WRITE-AFTER-WRITE")) << said;
  EXPECT_TRUE(has(said, "VUID-vkDestroyDevice-device-00378")) << said;
}

// --- arguments ---------------------------------------------------------------------------------

TEST_F(VulkanAPI, ArgumentsThatAreNullAreNamed)
{
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

TEST_F(VulkanAPI, ArgumentsOfOrdersOfRaysAreChecked)
{
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  RecordedTrace recorded(vulkan->handles);
  const size_t most = size_t(1) << 27;
  EXPECT_EQ(rtcGetVulkanRayOrderBytes(0), 0u);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
  EXPECT_GT(rtcGetVulkanRayOrderBytes(most), 16*most);
  EXPECT_EQ(rtcGetVulkanRayOrderBytes(most + 1), 0u);
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT);
  recorded.record([&](VkCommandBuffer commands) {
    const struct { VkCommandBuffer commands; VkDeviceAddress rays; size_t stride, count; VkDeviceAddress order; std::vector<std::string> message; } wrong[] = {
      {nullptr, 0x1000, 80, 1, 0x2000, {"commands"}},
      {commands, 0x1004, 80, 1, 0x2000, {"rays", "4100"}},
      {commands, 0x1000, 80, 1, 0x2004, {"order", "8196"}},
      {commands, 0, 80, 1, 0x2000, {"rays", "is 0"}},
      {commands, 0x1000, 80, 1, 0, {"order", "is 0"}},
      {commands, 0x1000, 24, 1, 0x2000, {"stride 24"}},
      {commands, 0x1000, 50, 1, 0x2000, {"stride 50"}},
      {commands, 0x1000, 80, most + 1, 0x2000, {std::to_string(most + 1)}},
      {commands, 0x1000, 4096, most/16, 0x2000, {"stride 4096", std::to_string(most/16)}}};
    for (const auto& w : wrong) {
      EXPECT_FALSE(rtcRecordVulkanRayOrder(uploaded.get(), w.commands, w.rays, w.stride, w.count, w.order));
      expectError(RTC_ERROR_INVALID_ARGUMENT, w.message);
    }
    EXPECT_FALSE(rtcRecordVulkanIntersectInOrder(uploaded.get(), commands, 0x1000, 1, 0x2004));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {"order", "8196"});
    EXPECT_FALSE(rtcRecordVulkanOccludedInOrder(uploaded.get(), commands, 0x1000, most + 1, 0x2000));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {std::to_string(most + 1)});
    EXPECT_TRUE(rtcRecordVulkanRayOrder(uploaded.get(), commands, 0, 80, 0, 0)) << "no rays are in order: " << embree.message;
  });
}

// As many as the API takes are more than a device takes in one dispatch. Nothing is submitted: the layer looks at limits as
// commands are recorded.
TEST_F(VulkanAPI, ManyRaysAreRecordedWithinTheLimitsOfTheDevice)
{
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
    EXPECT_TRUE(rtcRecordVulkanRayOrder(uploaded.get(), commands, 0x1000, sizeof(RTCRayHit), size_t(1) << 20, 0x2000)) << embree.message;
  });
}

// Their bytes would be a small number again in 64 bits.
TEST_F(VulkanAPI, MoreRaysThanMemoryCouldHaveAreAnError)
{
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  const size_t closest = SIZE_MAX/sizeof(RTCRayHit) + 2, any = SIZE_MAX/sizeof(RTCRay) + 2;
  EXPECT_EQ(rtcStartVulkanIntersect(uploaded.get(), rays.data(), closest), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"count " + std::to_string(closest)});
  EXPECT_EQ(rtcStartVulkanOccluded(uploaded.get(), &rays[0].ray, any), nullptr);
  expectError(RTC_ERROR_INVALID_ARGUMENT, {"count " + std::to_string(any)});
}

// Without an object there is no RTCDevice either: the error is the thread's.
TEST_F(VulkanAPI, ObjectsThatAreNullAreAnErrorOfTheThread)
{
  RTCVulkanDeviceInfo info;
  RTCVulkanHandles handles;
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
    [] { EXPECT_EQ(rtcGetVulkanSceneKinds(nullptr), 0u); },
    [&] { rtcGetVulkanSceneStatistics(nullptr, &statistics); },
    [&] { EXPECT_FALSE(rtcRecordVulkanIntersect(nullptr, commands, 16, 1)); },
    [&] { EXPECT_FALSE(rtcRecordVulkanOccluded(nullptr, commands, 16, 1)); },
    [&] { EXPECT_EQ(rtcStartVulkanIntersect(nullptr, &ray, 1), nullptr); },
    [&] { EXPECT_EQ(rtcStartVulkanOccluded(nullptr, &ray.ray, 1), nullptr); },
    [&] { EXPECT_FALSE(rtcRecordVulkanRayOrder(nullptr, commands, 16, 80, 1, 16)); },
    [&] { EXPECT_FALSE(rtcRecordVulkanIntersectInOrder(nullptr, commands, 16, 1, 16)); },
    [&] { EXPECT_FALSE(rtcRecordVulkanOccludedInOrder(nullptr, commands, 16, 1, 16)); },
    [] { rtcSetVulkanSceneRaySort(nullptr, true); },
    [] { EXPECT_FALSE(rtcIsVulkanTraceDone(nullptr)); },
    [] { EXPECT_FALSE(rtcWaitVulkanTrace(nullptr, nullptr, nullptr)); }};
  EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_NONE);
  for (size_t i = 0; i < std::size(calls); i++) {
    calls[i]();
    EXPECT_EQ(rtcGetDeviceError(nullptr), RTC_ERROR_INVALID_ARGUMENT) << "call " << i;
  }
}

TEST_F(VulkanAPI, HandlesThatAreMissingOrWrongAreNamed)
{
  const std::pair<const char*, void (*)(RTCVulkanHandles&)> removals[] = {
    {"getInstanceProcAddr", [](RTCVulkanHandles& h) { h.getInstanceProcAddr = nullptr; }},
    {"instance", [](RTCVulkanHandles& h) { h.instance = nullptr; }},
    {"physicalDevice", [](RTCVulkanHandles& h) { h.physicalDevice = nullptr; }},
    {"device", [](RTCVulkanHandles& h) { h.device = nullptr; }},
    {"queue", [](RTCVulkanHandles& h) { h.queue = nullptr; }},
    {"queueFamily 7000", [](RTCVulkanHandles& h) { h.queueFamily = 7000; }}};
  for (const auto& removal : removals) {
    RTCVulkanHandles handles = vulkan->handles;
    removal.second(handles);
    EXPECT_FALSE(open(handles));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {removal.first});
  }
}

TEST_F(VulkanAPI, AddressesOfRaysThatAreNoneOrNotAlignedAreErrors)
{
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  RecordedTrace recorded(vulkan->handles);
  recorded.record([&](VkCommandBuffer commands) {
    EXPECT_FALSE(rtcRecordVulkanIntersect(uploaded.get(), commands, 0x1008, 1));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {"rays", "4104", "multiple of 16"});
    EXPECT_FALSE(rtcRecordVulkanOccluded(uploaded.get(), commands, 0x1001, 1));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {"rays", "4097", "multiple of 16"});
    EXPECT_FALSE(rtcRecordVulkanIntersect(uploaded.get(), commands, 0, 1));
    expectError(RTC_ERROR_INVALID_ARGUMENT, {"rays"});
  });
}

TEST_F(VulkanAPI, KindsOfMemoryThatDoNotExistAreErrors)
{
  const SmallScene scene(embree);
  for (int memory : {-1, 3, 1000}) {
    RTCVulkanSceneArguments args;
    std::memcpy(&args.memory, &memory, sizeof(memory)); // as C may write it
    EXPECT_EQ(rtcNewVulkanScene(device.get(), scene, &args), nullptr);
    expectError(RTC_ERROR_INVALID_ARGUMENT, {"memory", std::to_string(memory)});
  }
}

TEST_F(VulkanAPI, DevicesAreFoundByIndexAndByAPartOfTheirName)
{
  const unsigned count = rtcGetVulkanDevices(embree, nullptr, 0);
  ASSERT_GE(count, 1u);
  std::vector<RTCVulkanDeviceInfo> infos(count + 1);
  std::memset(&infos[count], 0x5A, sizeof(infos[count]));
  const RTCVulkanDeviceInfo untouched = infos[count];
  EXPECT_EQ(rtcGetVulkanDevices(embree, infos.data(), count + 1), count);
  EXPECT_EQ(std::memcmp(&infos[count], &untouched, sizeof(untouched)), 0);
  EXPECT_EQ(rtcGetVulkanDevices(nullptr, nullptr, 0), count) << "device may be NULL";

  for (unsigned i = 0; i < count; i++)
    for (const std::string& which : {std::to_string(count), std::to_string(count + 100), std::string("4294967296"), std::string("no such device")}) {
      EXPECT_EQ(rtcNewVulkanDevice(embree, which.c_str()), nullptr);
      expectError(RTC_ERROR_INVALID_ARGUMENT, {"'" + which + "'", std::to_string(i) + " " + infos[i].name});
    }

  for (unsigned i = 0; i < count; i++) {
    if (infos[i].unsupported[0]) continue;
    std::string part = std::string(infos[i].name).substr(1, 5);
    std::transform(part.begin(), part.end(), part.begin(), [](unsigned char c) { return char(std::toupper(c)); });
    for (const std::string& which : {std::to_string(i), std::string(infos[i].name), part}) {
      const VulkanDevice opened(rtcNewVulkanDevice(embree, which.c_str()));
      ASSERT_TRUE(opened) << which << ": " << embree.message;
      RTCVulkanDeviceInfo info;
      rtcGetVulkanDeviceInfo(opened.get(), &info);
      EXPECT_TRUE(which != std::to_string(i) || !std::memcmp(&info, &infos[i], sizeof(info)));
      EXPECT_TRUE(has(info.name, which == part ? part.substr(0, 0) : which) || which == std::to_string(i));
      RTCVulkanHandles handles;
      rtcGetVulkanDeviceHandles(opened.get(), &handles);
      EXPECT_TRUE(handles.getInstanceProcAddr && handles.instance && handles.physicalDevice && handles.device && handles.queue);
    }
  }
  for (const char* which : {"", static_cast<const char*>(nullptr)}) {
    const VulkanDevice opened(rtcNewVulkanDevice(embree, which));
    EXPECT_TRUE(opened) << embree.message;
  }
}

TEST_F(VulkanAPI, ADeviceIsWhatWasGiven)
{
  RTCVulkanHandles handles;
  rtcGetVulkanDeviceHandles(device.get(), &handles);
  EXPECT_EQ(handles.device, vulkan->handles.device);
  EXPECT_EQ(handles.queue, vulkan->handles.queue);
  EXPECT_EQ(handles.hasFloat64, vulkan->handles.hasFloat64);
  RTCVulkanDeviceInfo info;
  rtcGetVulkanDeviceInfo(device.get(), &info);
  EXPECT_EQ(info.name, vulkan->name);
  EXPECT_STREQ(info.unsupported, "");
  EXPECT_NE(std::string(info.driver), "");
  EXPECT_GT(info.memoryBytes, 0u);
}

// --- what keeps what -----------------------------------------------------------------------------

TEST_F(VulkanAPI, EverythingKeepsWhatItNeeds)
{
  const std::vector<RTCRayHit> rays = raysFromAbove();
  std::vector<RTCRayHit> traced = rays, expected = rays;
  RTCVulkanTrace trace;
  {
    RTCVulkanScene kept;
    {
      const VulkanDevice other = open(vulkan->handles);
      const SmallScene scene(embree);
      for (RTCRayHit& ray : expected) ray = intersect(scene, ray);
      const VulkanScene uploaded = newVulkanScene(other, scene); // imported, where that can be
      ASSERT_TRUE(uploaded) << embree.message;
      rtcRetainVulkanScene(uploaded.get());
      kept = uploaded.get();
    }
    EXPECT_TRUE(cbvh::test::trace(kept, traced)) << "device and scene are released: " << embree.message;
    for (size_t i = 0; i < rays.size(); i++) EXPECT_EQ(traced[i].hit.geomID, expected[i].hit.geomID);
    trace = rtcStartVulkanIntersect(kept, rays.data(), rays.size());
    ASSERT_TRUE(trace) << embree.message;
    rtcReleaseVulkanScene(kept);
  }
  std::vector<RTCRayHit> again = rays;
  EXPECT_TRUE(rtcWaitVulkanTrace(trace, again.data(), nullptr)) << embree.message;
  EXPECT_TRUE(areSame(again, traced));
}

TEST_F(VulkanAPI, ADeviceLivesAsLongAsItIsRetained)
{
  RTCVulkanDevice other = open(vulkan->handles).release();
  rtcRetainVulkanDevice(other);
  rtcReleaseVulkanDevice(other);
  RTCVulkanDeviceInfo info;
  rtcGetVulkanDeviceInfo(other, &info);
  EXPECT_EQ(info.name, vulkan->name);
  rtcReleaseVulkanDevice(other);
  expectNoError();
}

// Its copy is of what the scene was.
TEST_F(VulkanAPI, ASceneOnADeviceDoesNotChangeWithTheSceneItIsOf)
{
  Scene scene(embree);
  const unsigned id = attach(scene, newTriangle(embree, 1));
  rtcCommitScene(scene);
  const VulkanScene before = upload(scene, RTC_VULKAN_MEMORY_COPY);
  const RTCGeometry geometry = rtcGetGeometry(scene, id);
  float* z = (float*)rtcGetGeometryBufferData(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  for (int i = 0; i < 3; i++) z[3*i + 2] = 2;
  rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  rtcCommitGeometry(geometry);
  EXPECT_FALSE(upload(scene));
  expectError(RTC_ERROR_INVALID_OPERATION, {"not committed"});
  rtcCommitScene(scene);
  const VulkanScene behind = upload(scene, RTC_VULKAN_MEMORY_COPY);
  const std::vector<RTCRayHit> rays = {makeRay({-0.5f, -0.5f, 5}, {0, 0, -1})};
  EXPECT_EQ(traceAll(before.get(), rays)[0].ray.tfar, 4);
  EXPECT_EQ(traceAll(behind.get(), rays)[0].ray.tfar, 3);
}

// --- scenes that are not taken ---------------------------------------------------------------------

TEST_F(VulkanAPI, ScenesThatAreNotCommittedAreErrors)
{
  Scene scene(embree);
  attach(scene, newTriangle(embree, 0));
  EXPECT_FALSE(upload(scene));
  expectError(RTC_ERROR_INVALID_OPERATION, {"not committed"});
  rtcCommitScene(scene);
  EXPECT_TRUE(upload(scene)) << embree.message;
  attach(scene, newTriangle(embree, 1));
  EXPECT_FALSE(upload(scene));
  expectError(RTC_ERROR_INVALID_OPERATION, {"not committed"});
}

// The scene's own RTCDevice may be another: both are told.
TEST_F(VulkanAPI, AnErrorOfASceneOfAnotherDeviceIsToldToTheVulkanDevicesToo)
{
  Device other;
  Scene scene(other);
  attach(scene, newTriangle(other, 1));
  EXPECT_FALSE(upload(scene));
  expectError(RTC_ERROR_INVALID_OPERATION, {"scene"});
  EXPECT_EQ(other.takeError(), RTC_ERROR_INVALID_OPERATION);
  EXPECT_TRUE(has(other.message, "not committed")) << other.message;
  rtcCommitScene(scene);
  const VulkanScene uploaded = upload(scene);
  ASSERT_TRUE(uploaded) << embree.message;
  const std::vector<RTCRayHit> rays = raysFromAbove();
  expectAsOnTheCPU(scene, rays, traceAll(uploaded.get(), rays));
}

struct RefusedGeometry
{
  const char* name;
  std::vector<std::string> message;
  std::function<RTCGeometry(RTCDevice)> make;  // committed; NULL if this build has none
  bool isNamed = true;                         // by its ID, in the message
};

template<typename Fill>
RTCGeometry newGeometry(RTCDevice device, RTCGeometryType type, const Fill& fill)
{
  RTCGeometry geometry = rtcNewGeometry(device, type);
  if (!geometry) return nullptr;
  fill(geometry);
  rtcCommitGeometry(geometry);
  return geometry;
}

const std::vector<Vec> square = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};

std::vector<RefusedGeometry> refusedGeometries()
{
  return {
    {"quad mesh", {"is a quad mesh"}, [](RTCDevice device) { return newGeometry(device, RTC_GEOMETRY_TYPE_QUAD, [](RTCGeometry g) {
      setBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, square);
      setBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, std::vector<std::array<unsigned, 4>>{{0, 1, 2, 3}});
    }); }},
    {"grid mesh", {"is a grid mesh"}, [](RTCDevice device) { return newGeometry(device, RTC_GEOMETRY_TYPE_GRID, [](RTCGeometry g) {
      setBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, std::vector<Vec>{square[0], square[1], square[3], square[2]});
      setBuffer(g, RTC_BUFFER_TYPE_GRID, 0, RTC_FORMAT_GRID, std::vector<RTCGrid>{{0, 2, 2, 2}});
    }); }},
    {"user geometry", {"is user geometry"}, [](RTCDevice device) { return newGeometry(device, RTC_GEOMETRY_TYPE_USER, [](RTCGeometry g) {
      rtcSetGeometryUserPrimitiveCount(g, 1);
      rtcSetGeometryBoundsFunction(g, [](const RTCBoundsFunctionArguments* args) { *args->bounds_o = {-1, -1, -1, 0, 1, 1, 1, 0}; }, nullptr);
      rtcSetGeometryIntersectFunction(g, [](const RTCIntersectFunctionNArguments*) {});
      rtcSetGeometryOccludedFunction(g, [](const RTCOccludedFunctionNArguments*) {});
    }); }},
    {"curve", {"is of curves or points"}, [](RTCDevice device) -> RTCGeometry {
      if (!rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_CURVE_GEOMETRY_SUPPORTED)) return nullptr;
      return newGeometry(device, RTC_GEOMETRY_TYPE_FLAT_LINEAR_CURVE, [](RTCGeometry g) {
        setBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, std::vector<std::array<float, 4>>{{-1, 0, 0, 0.1f}, {1, 0, 0, 0.1f}});
        setBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT, std::vector<unsigned>{0});
      });
    }},
    {"points", {"is of curves or points"}, [](RTCDevice device) -> RTCGeometry {
      if (!rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_POINT_GEOMETRY_SUPPORTED)) return nullptr;
      return newGeometry(device, RTC_GEOMETRY_TYPE_SPHERE_POINT, [](RTCGeometry g) {
        setBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT4, std::vector<std::array<float, 4>>{{0, 0, 0, 0.1f}});
      });
    }},
    {"triangle mesh with motion blur", {"motion blur", "2 time steps"}, [](RTCDevice device) { return newTriangle(device, 0, 2); }},
    {"surface with motion blur", {"motion blur"}, [](RTCDevice device) {
      SurfaceSettings settings = smallSurface(RTC_COMPRESSION_NONE);
      settings.timeSteps = 2;
      return newSurface(device, sheetCage(1), settings);
    }, false}, // its tree is met before the geometries are
    {"triangle mesh with an intersection filter", {"filter function"}, [](RTCDevice device) {
      const RTCGeometry g = newTriangle(device, 0);
      rtcSetGeometryIntersectFilterFunction(g, [](const RTCFilterFunctionNArguments*) {});
      rtcCommitGeometry(g);
      return g;
    }},
    {"surface with an occlusion filter", {"filter function"}, [](RTCDevice device) {
      const RTCGeometry g = newSurface(device, sheetCage(1), smallSurface(RTC_COMPRESSION_LEAF));
      rtcSetGeometryOccludedFilterFunction(g, [](const RTCFilterFunctionNArguments*) {});
      rtcCommitGeometry(g);
      return g;
    }}};
}

TEST_F(VulkanAPI, GeometriesThatAreNotTakenAreNamedUnlessTheyAreDisabled)
{
  for (const RefusedGeometry& refused : refusedGeometries())
  {
    SCOPED_TRACE(refused.name);
    const RTCGeometry geometry = refused.make(embree);
    if (!geometry) { expectNoError(); continue; }
    Scene scene(embree);
    rtcAttachGeometryByID(scene, geometry, 3);   // and there are IDs without a geometry before it
    attach(scene, newTriangle(embree, 1));
    rtcCommitScene(scene);
    expectNoError();
    EXPECT_FALSE(upload(scene));
    expectError(RTC_ERROR_INVALID_OPERATION, {refused.isNamed ? "geometry 3 " : ""});
    expectMessage(refused.message);

    Scene above(embree);
    attach(above, newTriangle(embree, 2));
    attach(above, newInstance(embree, scene, 0));
    rtcCommitScene(above);
    EXPECT_FALSE(upload(above));
    expectError(RTC_ERROR_INVALID_OPERATION, {refused.isNamed ? "geometry 3 of an instanced scene" : ""});
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

TEST_F(VulkanAPI, InstancesThatAreNotTakenAreNamed)
{
  Scene triangle(embree), instance(embree), above(embree), moving(embree);
  attach(triangle, newTriangle(embree, 0));
  rtcCommitScene(triangle);
  attach(instance, newTriangle(embree, 1));
  attach(instance, newInstance(embree, triangle, 0));
  rtcCommitScene(instance);
  EXPECT_TRUE(upload(instance)) << embree.message;
  attach(above, newInstance(embree, instance, 0));
  rtcCommitScene(above);
  EXPECT_FALSE(upload(above));
  expectError(RTC_ERROR_INVALID_OPERATION, {"geometry 1 of an instanced scene", "is an instance", "RTC_MAX_INSTANCE_LEVEL_COUNT"});
  attach(moving, newTriangle(embree, 1));
  attach(moving, newInstance(embree, triangle, 0, 2));
  rtcCommitScene(moving);
  EXPECT_FALSE(upload(moving));
  expectError(RTC_ERROR_INVALID_OPERATION, {"geometry 1 ", "motion blur", "2 time steps"});
  rtcDisableGeometry(rtcGetGeometry(moving, 1));
  rtcCommitScene(moving);
  EXPECT_TRUE(upload(moving)) << embree.message;
}

// An RTCDevice that runs out of memory during an upload leaves nothing of it behind.
TEST_F(VulkanAPI, AnUploadThatEmbreeHasNoMemoryForIsAnError)
{
  struct Limit
  {
    ssize_t live = 0, most = std::numeric_limits<ssize_t>::max();
    static bool monitor(void* self, ssize_t bytes, bool)
    {
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

// --- what is traced ----------------------------------------------------------------------------------

TEST_F(VulkanAPI, EmptyScenesTraceNothing)
{
  const std::vector<RTCRayHit> rays = raysFromAbove();
  const std::vector<RTCRay> shadowRays = withoutHits(rays);
  Scene empty(embree), disabled(embree), noFaces(embree), ofEmpty(embree);
  rtcCommitScene(empty);
  attach(disabled, newTriangle(embree, 0));
  rtcDisableGeometry(rtcGetGeometry(disabled, 0));
  rtcCommitScene(disabled);
  Cage none = sheetCage(1);
  none.holes = {0};
  addSurface(embree, noFaces, none, smallSurface(RTC_COMPRESSION_LEAF));
  rtcCommitScene(noFaces);
  attach(ofEmpty, newInstance(embree, empty, 1));
  rtcCommitScene(ofEmpty);
  for (RTCScene scene : {RTCScene(empty), RTCScene(disabled), RTCScene(noFaces), RTCScene(ofEmpty)})
    for (RTCVulkanMemory memory : {RTC_VULKAN_MEMORY_COPY, RTC_VULKAN_MEMORY_AUTO}) {
      const VulkanScene uploaded = upload(scene, memory);
      ASSERT_TRUE(uploaded) << embree.message;
      EXPECT_TRUE(areSame(traceAll(uploaded.get(), rays), rays));
      std::vector<RTCRay> traced = shadowRays;
      EXPECT_TRUE(trace(uploaded.get(), traced));
      EXPECT_TRUE(areSame(traced, shadowRays));
    }
}

TEST_F(VulkanAPI, NoRaysAreTracedAtOnce)
{
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  std::vector<RTCRayHit> none;
  std::vector<RTCRay> noShadowRays;
  EXPECT_TRUE(trace(uploaded.get(), none)) << embree.message;
  EXPECT_TRUE(trace(uploaded.get(), noShadowRays)) << embree.message;
  RecordedTrace recorded(vulkan->handles);
  recorded.record([&](VkCommandBuffer commands) {
    EXPECT_TRUE(rtcRecordVulkanIntersect(uploaded.get(), commands, 0, 0));
    EXPECT_TRUE(rtcRecordVulkanOccluded(uploaded.get(), commands, 0, 0));
  });
}

TEST_F(VulkanAPI, RaysThatAreInactiveAreLeftAlone)
{
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  const float inf = std::numeric_limits<float>::infinity();
  std::vector<RTCRayHit> rays = raysFromAbove();
  const std::vector<RTCRayHit> hits = traceAll(uploaded.get(), rays);
  const size_t active = rays.size();
  for (const auto& [tnear, tfar] : {std::make_pair(0.0f, -inf), std::make_pair(7.0f, 6.0f), std::make_pair(inf, 0.0f), std::make_pair(0.0f, -1.0f)}) {
    RTCRayHit ray = rays[0];
    ray.ray.tnear = tnear;
    ray.ray.tfar = tfar;
    ray.hit.u = 77;
    ray.hit.primID = 78;
    rays.push_back(ray);
  }
  const std::vector<RTCRayHit> traced = traceAll(uploaded.get(), rays);
  std::vector<RTCRayHit> expected = hits;
  expected.insert(expected.end(), rays.begin() + ptrdiff_t(active), rays.end());
  EXPECT_TRUE(areSame(traced, expected)) << "the others are traced, those are the same to the last bit";
  const std::vector<RTCRay> shadowRays = withoutHits(rays);
  std::vector<RTCRay> occluded = shadowRays;
  EXPECT_TRUE(trace(uploaded.get(), occluded));
  for (size_t i = 0; i < rays.size(); i++) {
    if (i < active && isHit(hits[i])) { EXPECT_EQ(occluded[i].tfar, -inf) << i; }
    else { EXPECT_EQ(std::memcmp(&occluded[i], &shadowRays[i], sizeof(RTCRay)), 0) << i; }
  }
}

TEST_F(VulkanAPI, StatisticsSayWhereMemoryIs)
{
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
  EXPECT_EQ(copied.numGeometries, 5u) << "three, and two of the instanced scene, which is there once";
  EXPECT_EQ(copied.numBlocks, 4u*4);
  EXPECT_GT(copied.numNodes, 0u);
  EXPECT_GT(copied.topLevelBytes, 0u);
  EXPECT_GE(copied.deviceBytes, copied.topLevelBytes + statisticsOf(instanced).frameBytes + statisticsOf(instanced).nodeBytes + statisticsOf(instanced).leafBytes);
  EXPECT_EQ(copied.stackSize % 32, 0u);
  EXPECT_NE(rtcGetVulkanSceneAddress(copy.get()), 0u);
  EXPECT_EQ(rtcGetVulkanSceneAddress(copy.get()) % 16, 0u);
  EXPECT_NE(rtcGetVulkanSceneKinds(copy.get()), 0u);
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

// --- ways to trace -------------------------------------------------------------------------------------

TEST_F(VulkanAPI, ARecordedTraceGivesWhatOneFromTheHostGives)
{
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  Random random(223);
  const std::vector<RTCRayHit> rays = raysAt(random, 333);
  const std::vector<RTCRayHit> expected = traceAll(uploaded.get(), rays);
  std::vector<RTCRay> shadowRays = withoutHits(rays), occluded = shadowRays;
  ASSERT_TRUE(trace(uploaded.get(), occluded));

  // both in one command buffer, the second part of the rays apart from the first
  RecordedTrace recorded(vulkan->handles);
  RayBuffer closest(vulkan->handles, rays.data(), rays.size()*sizeof(RTCRayHit));
  RayBuffer any(vulkan->handles, shadowRays.data(), shadowRays.size()*sizeof(RTCRay));
  const size_t first = 64;
  recorded.record([&](VkCommandBuffer commands) {
    EXPECT_TRUE(rtcRecordVulkanIntersect(uploaded.get(), commands, closest.address, first));
    EXPECT_TRUE(rtcRecordVulkanIntersect(uploaded.get(), commands, closest.address + first*sizeof(RTCRayHit), rays.size() - first));
    EXPECT_TRUE(rtcRecordVulkanOccluded(uploaded.get(), commands, any.address, shadowRays.size()));
  });
  recorded.submitAndWait();
  EXPECT_EQ(std::memcmp(closest.mapped, expected.data(), expected.size()*sizeof(RTCRayHit)), 0);
  EXPECT_EQ(std::memcmp(any.mapped, occluded.data(), occluded.size()*sizeof(RTCRay)), 0);
}

TEST_F(VulkanAPI, ATraceInOrderGivesWhatOneWithoutGives)
{
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  Random random(239);
  const std::vector<RTCRayHit> rays = raysAt(random, 5000); // more than one tile of the sort
  const std::vector<RTCRay> shadowRays = withoutHits(rays);
  std::vector<RTCRayHit> expected = rays;
  std::vector<RTCRay> occluded = shadowRays;
  ASSERT_TRUE(trace(uploaded.get(), expected) && trace(uploaded.get(), occluded)) << embree.message;

  RTCVulkanTimes times;
  std::vector<RTCRayHit> sorted = rays;
  std::vector<RTCRay> sortedShadowRays = shadowRays;
  rtcSetVulkanSceneRaySort(uploaded.get(), true);
  ASSERT_TRUE(trace(uploaded.get(), sorted, &times) && trace(uploaded.get(), sortedShadowRays)) << embree.message;
  EXPECT_TRUE(areSame(sorted, expected));
  EXPECT_TRUE(areSame(sortedShadowRays, occluded));
  EXPECT_GT(times.sortSeconds, 0);

  RecordedTrace recorded(vulkan->handles);
  const size_t bytes = rtcGetVulkanRayOrderBytes(rays.size());
  const std::vector<char> nothing(bytes, 0x55);
  RayBuffer closest(vulkan->handles, rays.data(), rays.size()*sizeof(RTCRayHit)), any(vulkan->handles, shadowRays.data(), shadowRays.size()*sizeof(RTCRay));
  RayBuffer orders[2] = {{vulkan->handles, nothing.data(), bytes}, {vulkan->handles, nothing.data(), bytes}};
  recorded.record([&](VkCommandBuffer commands) {
    EXPECT_TRUE(rtcRecordVulkanRayOrder(uploaded.get(), commands, closest.address, sizeof(RTCRayHit), rays.size(), orders[0].address));
    EXPECT_TRUE(rtcRecordVulkanIntersectInOrder(uploaded.get(), commands, closest.address, rays.size(), orders[0].address));
    EXPECT_TRUE(rtcRecordVulkanRayOrder(uploaded.get(), commands, any.address, sizeof(RTCRay), rays.size(), orders[1].address));
    EXPECT_TRUE(rtcRecordVulkanOccludedInOrder(uploaded.get(), commands, any.address, rays.size(), orders[1].address));
  });
  recorded.submitAndWait();
  EXPECT_EQ(std::memcmp(closest.mapped, expected.data(), expected.size()*sizeof(RTCRayHit)), 0);
  EXPECT_EQ(std::memcmp(any.mapped, occluded.data(), occluded.size()*sizeof(RTCRay)), 0);
}

TEST_F(VulkanAPI, SeveralTracesAreInFlightAtOnce)
{
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene), other = upload(scene, RTC_VULKAN_MEMORY_COPY);
  Random random(227);
  std::vector<std::vector<RTCRayHit>> rays;
  std::vector<RTCVulkanTrace> traces;
  for (int i = 0; i < 8; i++) {
    rays.push_back(raysAt(random, 40));
    std::vector<RTCRayHit> read = rays.back();
    traces.push_back(rtcStartVulkanIntersect(i % 2 ? uploaded.get() : other.get(), read.data(), read.size()));
    ASSERT_TRUE(traces.back()) << embree.message;
    std::memset(read.data(), 0xFF, read.size()*sizeof(RTCRayHit)); // it was read at once
  }
  for (int i : {3, 7, 0, 1, 6, 5, 2, 4}) {
    std::vector<RTCRayHit> traced(rays[size_t(i)].size());
    while (i % 2 && !rtcIsVulkanTraceDone(traces[size_t(i)])) std::this_thread::yield();
    RTCVulkanTimes times = {-1, -1, -1};
    ASSERT_TRUE(rtcWaitVulkanTrace(traces[size_t(i)], traced.data(), &times)) << embree.message;
    EXPECT_GE(times.seconds, 0);
    EXPECT_GE(times.copySeconds, 0);
    expectAsOnTheCPU(scene, rays[size_t(i)], traced);
  }
}

TEST_F(VulkanAPI, RaysThatNobodyWantsAreTracedAndReleased)
{
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  const std::vector<RTCRayHit> rays = raysFromAbove();
  const RTCVulkanTrace trace = rtcStartVulkanIntersect(uploaded.get(), rays.data(), rays.size());
  EXPECT_TRUE(rtcWaitVulkanTrace(trace, nullptr, nullptr)) << embree.message;
}

TEST_F(VulkanAPI, ThreadsTraceOneSceneAtOnce)
{
  const SmallScene scene(embree);
  const VulkanScene uploaded = upload(scene);
  Random random(229);
  const std::vector<RTCRayHit> rays = raysAt(random, 100);
  std::vector<RTCRayHit> hits = rays;
  for (RTCRayHit& hit : hits) hit = intersect(scene, hit);
  std::vector<RTCRayHit> traced[2];
  bool alike[2] = {true, true};
  auto work = [&](int id) {
    for (int i = 0; i < 10; i++) {
      std::vector<RTCRayHit> mine = rays;
      std::vector<RTCRay> shadowRays = withoutHits(rays);
      alike[id] = alike[id] && trace(uploaded.get(), mine) && trace(uploaded.get(), shadowRays);
      for (size_t k = 0; k < rays.size(); k++) alike[id] = alike[id] && (shadowRays[k].tfar < 0) == isHit(mine[k]);
      alike[id] = alike[id] && (i == 0 || areSame(mine, traced[id]));
      traced[id] = mine;
      alike[id] = alike[id] && newVulkanScene(device, scene, RTC_VULKAN_MEMORY_COPY);
    }
  };
  std::thread one(work, 0), other(work, 1);
  one.join();
  other.join();
  EXPECT_TRUE(alike[0] && alike[1]) << embree.message;
  EXPECT_TRUE(areSame(traced[0], traced[1]));
  expectAsOnTheCPU(scene, rays, traced[0]);
}

} // namespace
} // namespace cbvh::test
