// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

/* The API of include/embree3/rtcore_vulkan.h: validates arguments, and reports exceptions to the RTCDevice with which a
 * device was created. */

#define RTC_EXPORT_API

#include "ray_order.h"
#include "structs.h"
#include "trace.h"

#include "kernels/cbvh/operations/errors.h"

#include <algorithm>
#include <cstring>
#include <exception>
#include <new>

using namespace embree::vulkan;
namespace core = embree::core;

/* For operations/struct_size.cpp, which this library compiles without operations/errors.cpp. */
void embree::core::throwInvalidArgument(const std::string& text) {
  throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, text);
}

namespace {

/* Calls the closure. If it throws, returns false and reports the exception to the device (NULL: to the calling thread).
 * Does not report a VulkanError with RTC_ERROR_NONE, see error.h. */
template<typename Closure>
bool guarded(RTCDevice device, const Closure& closure) {
  try {
    closure();
    return true;
  } catch (const VulkanError& error) {
    if (error.code != RTC_ERROR_NONE) rtcRaiseDeviceError(device, error.code, error.what());
  } catch (const std::bad_alloc&) {
    rtcRaiseDeviceError(device, RTC_ERROR_OUT_OF_MEMORY, "out of memory");
  } catch (const std::exception& error) { rtcRaiseDeviceError(device, RTC_ERROR_UNKNOWN, error.what()); }
  return false;
}

void require(const void* argument, const char* name) {
  if (!argument) throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, std::string(name) + " is NULL");
}

template<typename T>
void write(T* to, const T& from, const char* name) {
  require(to, name);
  core::writeStruct(to, from);
}

/* An application's array of `count` structs, which may have the size of another version. The constructor throws
 * RTC_ERROR_INVALID_ARGUMENT for an invalid structSize of the first struct, at() if struct i has another size. */
class DeviceInfos {
public:
  DeviceInfos(RTCVulkanDeviceInfo* first, size_t count) : first(first), size(0) {
    if (count == 0) return;
    core::requireStruct(first);
    std::memcpy(&size, first, sizeof(size));
  }

  RTCVulkanDeviceInfo* at(size_t i) const {
    char* const info = (char*)first + i * size;
    size_t own;
    std::memcpy(&own, info, sizeof(own));
    if (own != size)
      core::throwInvalidArgument("RTCVulkanDeviceInfo: invalid structSize " + std::to_string(own) + " of infos[" +
                                 std::to_string(i) + "]: expected " + std::to_string(size) + ", as infos[0] has it");
    return (RTCVulkanDeviceInfo*)info;
  }

private:
  RTCVulkanDeviceInfo* const first;
  size_t size;
};

Device* deviceOf(RTCVulkanDevice device) { return reinterpret_cast<Device*>(device); }
Scene* sceneOf(RTCVulkanScene scene) { return reinterpret_cast<Scene*>(scene); }
Trace* traceOf(RTCVulkanTrace trace) { return reinterpret_cast<Trace*>(trace); }

RTCDevice embreeOf(RTCVulkanDevice device) { return device ? deviceOf(device)->embree : nullptr; }
RTCDevice embreeOf(RTCVulkanScene scene) { return scene ? sceneOf(scene)->device.embree : nullptr; }

void requireAligned(VkDeviceAddress address, const char* name) {
  if (address % 16)
    throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, std::string("invalid ") + name + " " + std::to_string(address) +
                                                      ": expected an address that is a multiple of 16");
}

bool record(RTCVulkanScene hscene, Query query, VkCommandBuffer commands, VkDeviceAddress rays, size_t count,
            VkDeviceAddress order = 0) {
  return guarded(embreeOf(hscene), [&]() {
    require(hscene, "scene");
    require(commands, "commands");
    if (count && !rays) throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, "the address of rays is 0");
    requireAligned(rays, "rays");
    requireAligned(order, "order");
    if (order) rayOrderBytes(count); // throws if there are too many rays
    Scene& scene = *sceneOf(hscene);
    scene.record(query, scene.device.pipeline(query, scene.usesRayQuery, scene.kinds, scene.statistics.stackSize),
                 commands, rays, count, order);
  });
}

RTCVulkanTrace start(RTCVulkanScene scene, Query query, const void* rays, size_t count) {
  Trace* trace = nullptr;
  guarded(embreeOf(scene), [&]() {
    require(scene, "scene");
    if (count) require(rays, "rays");
    trace = new Trace(*sceneOf(scene), query, rays, count);
  });
  return reinterpret_cast<RTCVulkanTrace>(trace);
}

} // namespace

RTC_NAMESPACE_BEGIN

/* --- devices ---------------------------------------------------------------------------- */

RTC_API unsigned int rtcGetVulkanDevices(RTCDevice device, RTCVulkanDeviceInfo* infos, unsigned int capacity) {
  unsigned int count = 0;
  guarded(device, [&]() {
    const DeviceInfos written(infos, infos ? capacity : 0);
    const VulkanInstance vulkan;
    const std::vector<VkPhysicalDevice> devices = vulkan.devices();
    const size_t numWritten = infos ? std::min(size_t(capacity), devices.size()) : 0;
    for (size_t i = 0; i < numWritten; i++) written.at(i); // checks all sizes before writing
    for (size_t i = 0; i < numWritten; i++) core::writeStruct(written.at(i), examineDevice(vulkan.vk, devices[i]).info);
    count = (unsigned int)devices.size();
  });
  return count;
}

RTC_API RTCVulkanDevice rtcNewVulkanDevice(RTCDevice embree, const char* selector) {
  Device* device = nullptr;
  guarded(embree, [&]() { device = new Device(embree, selector); });
  return reinterpret_cast<RTCVulkanDevice>(device);
}

RTC_API RTCVulkanDevice rtcNewVulkanDeviceFromHandles(RTCDevice embree, const RTCVulkanDeviceHandles* handles) {
  Device* device = nullptr;
  guarded(embree, [&]() {
    require(handles, "handles");
    const RTCVulkanDeviceHandles converted = core::readStruct(handles);
    require((const void*)converted.getInstanceProcAddr, "getInstanceProcAddr");
    require(converted.instance, "instance");
    require(converted.physicalDevice, "physicalDevice");
    require(converted.device, "device");
    require(converted.queue, "queue");
    device = new Device(embree, converted);
  });
  return reinterpret_cast<RTCVulkanDevice>(device);
}

RTC_API void rtcRetainVulkanDevice(RTCVulkanDevice device) {
  guarded(embreeOf(device), [&]() {
    require(device, "device");
    deviceOf(device)->retain();
  });
}

RTC_API void rtcReleaseVulkanDevice(RTCVulkanDevice device) {
  guarded(nullptr, [&]() {
    require(device, "device");
    deviceOf(device)->release();
  });
}

RTC_API void rtcGetVulkanDeviceInfo(RTCVulkanDevice device, RTCVulkanDeviceInfo* info) {
  guarded(embreeOf(device), [&]() {
    require(device, "device");
    write(info, deviceOf(device)->capabilities.info, "info");
  });
}

RTC_API void rtcGetVulkanDeviceHandles(RTCVulkanDevice device, RTCVulkanDeviceHandles* handles) {
  guarded(embreeOf(device), [&]() {
    require(device, "device");
    write(handles, deviceOf(device)->handles, "handles");
  });
}

/* --- scenes ----------------------------------------------------------------------------- */

RTC_API RTCVulkanScene rtcNewVulkanScene(RTCVulkanDevice device, RTCScene from,
                                         const RTCVulkanSceneArguments* arguments) {
  Scene* scene = nullptr;
  guarded(embreeOf(device), [&]() {
    require(device, "device");
    require(from, "scene");
    const RTCVulkanSceneArguments args = arguments ? core::readStruct(arguments) : RTCVulkanSceneArguments();
    int memory, traversal; // copied as integers: reading an invalid value as an enum is undefined behavior
    std::memcpy(&memory, &args.memory, sizeof(memory));
    std::memcpy(&traversal, &args.traversal, sizeof(traversal));
    if (memory < RTC_VULKAN_MEMORY_AUTO || memory > RTC_VULKAN_MEMORY_IMPORT)
      throw VulkanError(RTC_ERROR_INVALID_ARGUMENT,
                        "invalid memory " + std::to_string(memory) + ": expected AUTO, COPY or IMPORT");
    SceneOptions options;
    options.memory = RTCVulkanMemory(memory);
    options.previousScene = sceneOf(args.previousScene);
    if (traversal < RTC_VULKAN_TRAVERSAL_COMPUTE || traversal > RTC_VULKAN_TRAVERSAL_RAY_QUERY)
      throw VulkanError(RTC_ERROR_INVALID_ARGUMENT,
                        "invalid traversal " + std::to_string(traversal) + ": expected COMPUTE or RAY_QUERY");
    options.usesRayQuery = traversal == RTC_VULKAN_TRAVERSAL_RAY_QUERY;
    if (options.usesRayQuery && !deviceOf(device)->handles.hasRayQuery)
      throw VulkanError(RTC_ERROR_INVALID_OPERATION,
                        std::string("the Vulkan device ") + deviceOf(device)->capabilities.info.name +
                            " has no ray queries, or they are not enabled (VK_KHR_acceleration_structure, "
                            "VK_KHR_ray_query)");
    const Scene* const previous = options.previousScene;
    if (previous && (!options.usesRayQuery || !previous->usesRayQuery || &previous->device != deviceOf(device)))
      throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, "invalid previousScene: expected NULL or, if the scene is for ray "
                                                    "queries, a scene for ray queries of the same device");
    scene = new Scene(*deviceOf(device), from, options);
  });
  return reinterpret_cast<RTCVulkanScene>(scene);
}

RTC_API void rtcRetainVulkanScene(RTCVulkanScene scene) {
  guarded(embreeOf(scene), [&]() {
    require(scene, "scene");
    sceneOf(scene)->retain();
  });
}

RTC_API void rtcReleaseVulkanScene(RTCVulkanScene scene) {
  guarded(nullptr, [&]() {
    require(scene, "scene");
    sceneOf(scene)->release();
  });
}

RTC_API VkDeviceAddress rtcGetVulkanSceneAddress(RTCVulkanScene scene) {
  VkDeviceAddress address = 0;
  guarded(embreeOf(scene), [&]() {
    require(scene, "scene");
    address = sceneOf(scene)->address;
  });
  return address;
}

RTC_API unsigned int rtcGetVulkanSceneLeafKinds(RTCVulkanScene scene) {
  unsigned int kinds = 0;
  guarded(embreeOf(scene), [&]() {
    require(scene, "scene");
    kinds = sceneOf(scene)->kinds;
  });
  return kinds;
}

RTC_API unsigned int rtcGetVulkanSceneInstances(RTCVulkanScene scene, VkAccelerationStructureInstanceKHR* instances,
                                                unsigned int capacity) {
  unsigned int count = 0;
  guarded(embreeOf(scene), [&]() {
    require(scene, "scene");
    if (!sceneOf(scene)->usesRayQuery)
      throw VulkanError(RTC_ERROR_INVALID_OPERATION, "the scene is not for ray queries");
    const auto& all = sceneOf(scene)->queryStructures().instances;
    count = (unsigned int)(all.size());
    if (instances) std::copy_n(all.begin(), std::min(count, capacity), instances);
  });
  return count;
}

RTC_API void rtcGetVulkanSceneStatistics(RTCVulkanScene scene, RTCVulkanSceneStatistics* statistics) {
  guarded(embreeOf(scene), [&]() {
    require(scene, "scene");
    write(statistics, sceneOf(scene)->statistics, "statistics");
  });
}

/* --- tracing ---------------------------------------------------------------------------- */

RTC_API bool rtcRecordVulkanIntersect(RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays,
                                      size_t count) {
  return record(scene, CLOSEST_HIT, commands, rays, count);
}

RTC_API bool rtcRecordVulkanOccluded(RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays,
                                     size_t count) {
  return record(scene, ANY_HIT, commands, rays, count);
}

RTC_API size_t rtcGetVulkanRayOrderBytes(size_t count) {
  size_t bytes = 0;
  guarded(nullptr, [&]() { bytes = rayOrderBytes(count); });
  return bytes;
}

RTC_API bool rtcRecordVulkanRayOrder(RTCVulkanScene hscene, VkCommandBuffer commands, VkDeviceAddress rays,
                                     size_t stride, size_t count, VkDeviceAddress order) {
  return guarded(embreeOf(hscene), [&]() {
    require(hscene, "scene");
    require(commands, "commands");
    requireAligned(rays, "rays");
    requireAligned(order, "order");
    if (count && (!rays || !order))
      throw VulkanError(RTC_ERROR_INVALID_ARGUMENT, "the address of rays or of order is 0");
    if (stride % 4 || stride < 28)
      throw VulkanError(RTC_ERROR_INVALID_ARGUMENT,
                        "invalid stride " + std::to_string(stride) +
                            ": expected a multiple of 4, at least 28 (origin, tnear, direction)");
    rayOrderBytes(count); // throws if there are too many rays
    const Scene& scene = *sceneOf(hscene);
    if (count)
      recordRayOrder(scene, sceneOf(hscene)->device.makeOrderPipelines(), commands, {rays, stride, count, order});
  });
}

RTC_API bool rtcRecordVulkanIntersectInOrder(RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays,
                                             size_t count, VkDeviceAddress order) {
  return record(scene, CLOSEST_HIT, commands, rays, count, order);
}

RTC_API bool rtcRecordVulkanOccludedInOrder(RTCVulkanScene scene, VkCommandBuffer commands, VkDeviceAddress rays,
                                            size_t count, VkDeviceAddress order) {
  return record(scene, ANY_HIT, commands, rays, count, order);
}

RTC_API void rtcSetVulkanSceneRaySorting(RTCVulkanScene scene, bool enabled) {
  guarded(embreeOf(scene), [&]() {
    require(scene, "scene");
    sceneOf(scene)->sortsRays = enabled;
  });
}

RTC_API RTCVulkanTrace rtcStartVulkanIntersect(RTCVulkanScene scene, const RTCRayHit* rays, size_t count) {
  return start(scene, CLOSEST_HIT, rays, count);
}

RTC_API RTCVulkanTrace rtcStartVulkanOccluded(RTCVulkanScene scene, const RTCRay* rays, size_t count) {
  return start(scene, ANY_HIT, rays, count);
}

RTC_API bool rtcIsVulkanTraceDone(RTCVulkanTrace trace) {
  bool done = false;
  guarded(trace ? traceOf(trace)->device.embree : nullptr, [&]() {
    require(trace, "trace");
    done = traceOf(trace)->isDone();
  });
  return done;
}

RTC_API bool rtcFinishVulkanTrace(RTCVulkanTrace htrace, void* rays, RTCVulkanTraceTimes* times) {
  /* retained, because deleting the trace may release the RTCDevice that receives the error */
  const RTCDevice embree = htrace ? traceOf(htrace)->device.embree : nullptr;
  if (embree) rtcRetainDevice(embree);
  const bool done = guarded(embree, [&]() {
    require(htrace, "trace");
    const std::unique_ptr<Trace> trace(traceOf(htrace));
    if (times) core::requireStruct(times);
    RTCVulkanTraceTimes known;
    trace->finish(rays, times ? &known : nullptr);
    if (times) core::writeStruct(times, known);
  });
  if (embree) rtcReleaseDevice(embree);
  return done;
}

RTC_NAMESPACE_END
