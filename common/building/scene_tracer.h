// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <embree3/rtcore.h>

#include <cstddef>

namespace programs {

/* One way to trace rays through a committed scene, which must outlive the tracer. */
class SceneTracer {
public:
  virtual ~SceneTracer() = default;

  /* Return the results of rtcIntersect1 and rtcOccluded1 for n rays; a Vulkan device returns them up to float rounding.
   * Thread-safe. Throw Error. */
  virtual void intersect(RTCRayHit* rays, size_t n) const = 0;
  virtual void occluded(RTCRay* rays, size_t n) const = 0;
};

/* Single rays, on the calling thread. */
class EmbreeTracer : public SceneTracer {
public:
  explicit EmbreeTracer(RTCScene scene) : scene(scene) {}

  void intersect(RTCRayHit* rays, size_t n) const override;
  void occluded(RTCRay* rays, size_t n) const override;

private:
  RTCScene scene;
};

/* Packets of 4, 8 or 16 rays, whichever fills a vector register, with the coherent flag, on the calling thread. */
class PacketTracer : public SceneTracer {
public:
  explicit PacketTracer(RTCScene scene) : scene(scene) {}

  void intersect(RTCRayHit* rays, size_t n) const override;
  void occluded(RTCRay* rays, size_t n) const override;

private:
  RTCScene scene;
};

} // namespace programs
