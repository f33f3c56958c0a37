// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#include "building/vulkan_tracer.h"
#include "basics/error.h"
#include "basics/setting_name.h"
#include "building/embree_device.h"

#ifdef CBVH_VULKAN
#include <embree3/rtcore_vulkan.h>
#endif

#include <chrono>
#include <map>

namespace programs {
namespace {

const std::string rayQueryName = "ray-query";

} // namespace

VulkanDeviceName::VulkanDeviceName(const std::string& name)
  : byRayQuery(name.compare(0, rayQueryName.size(), rayQueryName) == 0) {
  const size_t colon = name.find(':');
  if (colon != std::string::npos) selector = name.substr(colon + 1);
}

void validateTraceDevice(const std::string& name) {
  if (name == "cpu") return;
  const std::string backend = name.substr(0, name.find(':'));
  if (backend != "vulkan" && backend != rayQueryName)
    throw Error("unknown " + settingName("device") + " '" + name +
                "': expected cpu, vulkan or ray-query, the last two optionally followed by : and an index or a part of "
                "a device's name");
#ifndef CBVH_VULKAN
  throw Error(settingName("device") + " " + name +
              ": this build has no Vulkan, because it lacked Vulkan's headers, glslc or Python: expected cpu");
#endif
}

std::unique_ptr<SceneTracer> makeTracer(const std::string& device, RTCScene scene) {
  if (device == "cpu") return std::make_unique<EmbreeTracer>(scene);
  return VulkanTracer::create(device, scene);
}

#ifdef CBVH_VULKAN

namespace {

/* `errors` receives the errors of `device`. */
struct OpenDevice {
  explicit OpenDevice(const std::string& selector) : errors("") {
    device = rtcNewVulkanDevice(errors.handle(), selector.c_str());
    errors.check("opening a Vulkan device");
  }
  ~OpenDevice() { rtcReleaseVulkanDevice(device); }
  OpenDevice(const OpenDevice&) = delete;
  OpenDevice& operator=(const OpenDevice&) = delete;

  EmbreeDevice errors;
  RTCVulkanDevice device;
};

std::shared_ptr<OpenDevice> openDevice(const std::string& name) {
  static std::mutex mutex;
  static std::map<std::string, std::weak_ptr<OpenDevice>> devices;
  const std::string selector = VulkanDeviceName(name).selector;
  const std::lock_guard<std::mutex> lock(mutex);
  std::shared_ptr<OpenDevice> device = devices[selector].lock();
  if (!device) devices[selector] = device = std::make_shared<OpenDevice>(selector);
  return device;
}

class Tracer : public VulkanTracer {
public:
  Tracer(const std::string& name, RTCScene from) : device(openDevice(name)) {
    const auto start = std::chrono::steady_clock::now();
    RTCVulkanSceneArguments args = {};
    if (VulkanDeviceName(name).byRayQuery) args.traversal = RTC_VULKAN_TRAVERSAL_RAY_QUERY;
    scene = rtcNewVulkanScene(device->device, from, &args);
    device->errors.check("uploading a scene to a Vulkan device");
    if (!scene) throw Error("uploading a scene to a Vulkan device failed");
    RTCVulkanSceneStatistics statistics;
    rtcGetVulkanSceneStatistics(scene, &statistics);
    RTCVulkanDeviceInfo info;
    rtcGetVulkanDeviceInfo(device->device, &info);
    sceneReport.device = std::string(info.name) + ", " + info.driver;
    sceneReport.uploadSeconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    sceneReport.deviceBytes = statistics.deviceBytes;
    sceneReport.importedBytes = statistics.importedBytes;
  }
  ~Tracer() override { rtcReleaseVulkanScene(scene); }

  void intersect(RTCRayHit* rays, size_t n) const override { timeIntersect(rays, n); }
  void occluded(RTCRay* rays, size_t n) const override { timeOccluded(rays, n); }

  double timeIntersect(RTCRayHit* rays, size_t n) const override {
    return finish(rtcStartVulkanIntersect(scene, rays, n), rays);
  }
  double timeOccluded(RTCRay* rays, size_t n) const override {
    return finish(rtcStartVulkanOccluded(scene, rays, n), rays);
  }

  const VulkanSceneReport& report() const override { return sceneReport; }

private:
  double finish(RTCVulkanTrace trace, void* rays) const {
    RTCVulkanTraceTimes times = {};
    if (!trace || !rtcFinishVulkanTrace(trace, rays, &times)) {
      device->errors.check("tracing on a Vulkan device");
      throw Error("tracing on a Vulkan device failed");
    }
    return times.traceSeconds;
  }

  std::shared_ptr<OpenDevice> device;
  RTCVulkanScene scene = nullptr;
  VulkanSceneReport sceneReport;
};

} // namespace

std::unique_ptr<VulkanTracer> VulkanTracer::create(const std::string& name, RTCScene scene) {
  return std::make_unique<Tracer>(name, scene);
}

std::shared_ptr<void> keepTraceDeviceOpen(const std::string& device) {
  return device == "cpu" ? nullptr : openDevice(device);
}

#else

std::unique_ptr<VulkanTracer> VulkanTracer::create(const std::string& name, RTCScene) {
  validateTraceDevice(name);
  return nullptr;
}

std::shared_ptr<void> keepTraceDeviceOpen(const std::string& device) {
  validateTraceDevice(device);
  return nullptr;
}

#endif

} // namespace programs
