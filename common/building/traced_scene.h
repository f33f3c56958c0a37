// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

/* A committed scene, built from a model or opened from a file. */

#include "building/scene_tracer.h"
#include "building/surface_hit.h"
#include "basics/vec.h"

#include <embree3/rtcore.h>

namespace programs {

class VulkanTracer;

class TracedScene {
public:
  virtual ~TracedScene() = default;

  virtual RTCScene handle() const = 0;

  /* vulkan() returns the same tracer if it traces on a Vulkan device, otherwise null. */
  virtual const SceneTracer& tracer() const = 0;
  virtual const VulkanTracer* vulkan() const { return nullptr; }

  /* Converts the hit or the miss of a ray that was traced. */
  virtual SurfaceHit surfaceHit(const RTCRayHit& ray) const = 0;

  /* Throws Error if rays reached damaged blocks of a file. Such rays miss these blocks. */
  virtual void check() const {}

  Box3f bounds() const {
    RTCBounds b;
    rtcGetSceneBounds(handle(), &b);
    return {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
  }
};

} // namespace programs
