// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Scenes on a Vulkan device, where this build has libembree3_vulkan. */

#include "building/scene_tracer.h"

#include <memory>
#include <string>

namespace cbvh {

/* A scene on a device. */
struct VulkanSceneReport
{
  std::string device;       // its own name, and its driver's
  double uploadSeconds = 0;
  size_t deviceBytes = 0;
  size_t importedBytes = 0; // blocks of the host's, used in place
};

class VulkanTracer : public SceneTracer
{
public:
  /* name: "vulkan", or "ray-query" where the driver finds the blocks, alone or with : and an index or a part of a device's name. The device is opened once
   * for as long as it is used. The scene outlives the tracer. Throws Error. */
  static std::unique_ptr<VulkanTracer> create(const std::string& name, RTCScene scene);

  virtual const VulkanSceneReport& report() const = 0;

  /* Seconds that the device took to trace the rays, copies left out; they get their hits. */
  virtual double timeIntersect(RTCRayHit* rays, size_t n) const = 0;
  virtual double timeOccluded(RTCRay* rays, size_t n) const = 0;
};

/* What a device traces a scene with: "cpu" and the names of VulkanTracer. Throws Error. */
std::unique_ptr<SceneTracer> makeTracer(const std::string& device, RTCScene scene);

/* Throws Error unless it is "cpu", "vulkan", "ray-query", or one of these with :..., and this build has that. */
void validateTraceDevice(const std::string& name);

} // namespace cbvh
