// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* How rays of a committed scene are traced: by Embree, or on a Vulkan device. */

#include <embree3/rtcore.h>

#include <cstddef>

namespace cbvh {

class SceneTracer
{
public:
  virtual ~SceneTracer() = default;

  /* Closest hits of n rays, and whether n rays hit anything, as rtcIntersect1 and rtcOccluded1 write them.
   * May be called by several threads. Throw Error. */
  virtual void intersect(RTCRayHit* rays, size_t n) const = 0;
  virtual void occluded(RTCRay* rays, size_t n) const = 0;
};

/* On the calling thread, one ray at a time. */
class EmbreeTracer : public SceneTracer
{
public:
  explicit EmbreeTracer(RTCScene scene) : scene(scene) {}

  void intersect(RTCRayHit* rays, size_t n) const override;
  void occluded(RTCRay* rays, size_t n) const override;

private:
  RTCScene scene;
};

/* On the calling thread, said to be coherent: rays that follow each other are a packet as wide as the instruction set. */
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
