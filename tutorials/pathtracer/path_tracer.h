// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Renders a picture sample by sample, on the processor or on a Vulkan device: the same paths with the same
 * random numbers, so that the pictures are equal but for rounding. */

#include "path.h"
#include "tracing/camera.h"
#include "tracing/shutter.h"

#include <memory>
#include <string>
#include <vector>

namespace cbvh {

using path::PathView;

/* up: of the scene. bounces: hits of a path behind its first. shutter: of models that move. */
PathView makePathView(const Camera& camera, Vec3f up, unsigned bounces, const Shutter& shutter);

class PathTracer
{
public:
  virtual ~PathTracer() = default;

  /* Traces one more path a pixel. Throws Error, Cancelled; the picture is none then. */
  void addSample() { addSample(count++); }

  unsigned samples() const { return count; }

  /* Mean of the samples so far, a value a pixel, linear, rows from the top. */
  std::vector<Vec3f> picture() const;

  /* What traces, in words. */
  virtual std::string deviceName() const = 0;

private:
  virtual void addSample(uint32_t sampleIndex) = 0;
  virtual std::vector<Vec3f> sums() const = 0;

  uint32_t count = 0;
};

/* On threads of the processor. scene: committed, outlives the tracer. */
std::unique_ptr<PathTracer> makeCpuPathTracer(RTCScene scene, const PathView& view, unsigned threads);

/* On a Vulkan device. which: as rtcNewVulkanDevice takes it. Throws Error. */
std::unique_ptr<PathTracer> makeVulkanPathTracer(RTCScene scene, const PathView& view, const std::string& which, bool byRayQuery = false);

} // namespace cbvh
