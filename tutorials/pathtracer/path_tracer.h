// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Renders a picture sample by sample, on the CPU or on a Vulkan device. Both trace the same paths with the same random
 * numbers, so their pictures differ only by rounding. */

#include "path.h"
#include "tracing/camera.h"
#include "tracing/shutter.h"

#include <memory>
#include <string>
#include <vector>

namespace cbvh {

using path::PathView;

/* `up` is the scene's up direction, `bounces` the number of hits after the first, `shutter` for models that move. */
PathView makePathView(const Camera& camera, Vec3f up, unsigned bounces, const Shutter& shutter);

class PathTracer
{
public:
  virtual ~PathTracer() = default;

  /* Traces one more path per pixel. Throws Error; the picture is invalid afterwards. */
  void addSample() { addSample(count++); }

  unsigned samples() const { return count; }

  /* Returns the mean of the samples so far, linear, one value per pixel, rows from the top. */
  std::vector<Vec3f> picture() const;

  /* Describes the device that traces. */
  virtual std::string deviceName() const = 0;

private:
  virtual void addSample(uint32_t sampleIndex) = 0;
  virtual std::vector<Vec3f> sums() const = 0;

  uint32_t count = 0;
};

/* Traces on CPU threads. The scene must be committed and must outlive the tracer. */
std::unique_ptr<PathTracer> makeCpuPathTracer(RTCScene scene, const PathView& view, unsigned threads);

/* Traces on a Vulkan device. `which` is an argument of rtcNewVulkanDevice. The scene must be committed. Throws
 * Error. */
std::unique_ptr<PathTracer> makeVulkanPathTracer(RTCScene scene, const PathView& view, const std::string& which,
                                                 bool byRayQuery = false);

} // namespace cbvh
