// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* Tracing of a committed scene, by Embree or on a Vulkan device. */

#include <embree3/rtcore.h>

#include <cstddef>

namespace cbvh {

class SceneTracer
{
public:
  virtual ~SceneTracer() = default;

  /* Find the closest hit of each of n rays, or whether each of n rays hits anything, with the results of rtcIntersect1
   * and rtcOccluded1. Thread-safe. Throw Error. */
  virtual void intersect(RTCRayHit* rays, size_t n) const = 0;
  virtual void occluded(RTCRay* rays, size_t n) const = 0;
};

/* Traces on the calling thread, one ray at a time. */
class EmbreeTracer : public SceneTracer
{
public:
  explicit EmbreeTracer(RTCScene scene) : scene(scene) {}

  void intersect(RTCRayHit* rays, size_t n) const override;
  void occluded(RTCRay* rays, size_t n) const override;

private:
  RTCScene scene;
};

/* Traces on the calling thread with the coherent flag: consecutive rays form packets as wide as the instruction set. */
class PacketTracer : public SceneTracer
{
public:
  explicit PacketTracer(RTCScene scene) : scene(scene) {}

  void intersect(RTCRayHit* rays, size_t n) const override;
  void occluded(RTCRay* rays, size_t n) const override;

private:
  RTCScene scene;
};

} // namespace cbvh
