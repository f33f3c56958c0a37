// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* On the CPU and on Vulkan devices, paths and random numbers are the same: pictures differ only by rounding. */

#include "path.h"
#include "tracing/camera.h"
#include "tracing/shutter.h"

#include <memory>
#include <string>
#include <vector>

namespace programs {

using path::PathView;

/* `bounces` is the number of hits after the first. */
PathView makePathView(const Camera& camera, Vec3f up, unsigned bounces, const Shutter& shutter);

class PathTracer {
public:
  virtual ~PathTracer() = default;

  /* Traces one path per pixel. Throws Error and Canceled; the picture is then invalid. */
  void addSample() { addSample(count++); }

  unsigned samples() const { return count; }

  /* Mean of the samples, linear, one value per pixel, rows from the top. Requires a sample. Throws Error. */
  std::vector<Vec3f> picture() const;

  virtual std::string deviceName() const = 0;

private:
  virtual void addSample(uint32_t sampleIndex) = 0;
  virtual std::vector<Vec3f> sums() const = 0;

  uint32_t count = 0;
};

/* The scene must be committed and outlive the tracer. */
std::unique_ptr<PathTracer> makeCpuPathTracer(RTCScene scene, const PathView& view, unsigned threads);

/* `selector` is for rtcNewVulkanDevice. The scene must be committed. Throws Error. */
std::unique_ptr<PathTracer> makeVulkanPathTracer(RTCScene scene, const PathView& view, const std::string& selector,
                                                 bool byRayQuery = false);

} // namespace programs
