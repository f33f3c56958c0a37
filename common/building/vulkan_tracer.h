// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tracing on a Vulkan device, if this build has libembree3_vulkan. */

#include "building/scene_tracer.h"

#include <memory>
#include <string>

namespace programs {

struct VulkanSceneReport {
  std::string device; // names of device and driver
  double uploadSeconds = 0;
  size_t deviceBytes = 0;
  size_t importedBytes = 0; // blocks used in place in host memory
};

class VulkanTracer : public SceneTracer {
public:
  /* `name` is "vulkan", or "ray-query" to let the driver's ray queries find the blocks; then optionally : and an
   * index or a part of a device's name. Tracers share an open device. The scene must outlive the tracer. Throws
   * Error. */
  static std::unique_ptr<VulkanTracer> create(const std::string& name, RTCScene scene);

  virtual const VulkanSceneReport& report() const = 0;

  /* As intersect and occluded. Return the device's seconds, without copies. */
  virtual double timeIntersect(RTCRayHit* rays, size_t n) const = 0;
  virtual double timeOccluded(RTCRay* rays, size_t n) const = 0;
};

/* The parts of a name as in VulkanTracer::create. */
struct VulkanDeviceName {
  explicit VulkanDeviceName(const std::string& name);

  bool byRayQuery;
  std::string selector; // index or a part of the device's name, for rtcNewVulkanDevice; empty for the first device
};

/* `device` is "cpu" or a name as in VulkanTracer::create. Throws Error. */
std::unique_ptr<SceneTracer> makeTracer(const std::string& device, RTCScene scene);

/* Keeps the device open between tracers while the result exists, because each opening compiles the shaders. `device`
 * is as in makeTracer. Throws Error. */
std::shared_ptr<void> keepTraceDeviceOpen(const std::string& device);

/* Throws Error unless this build supports makeTracer(name). */
void validateTraceDevice(const std::string& name);

} // namespace programs
