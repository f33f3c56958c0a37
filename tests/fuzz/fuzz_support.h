// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

// Helpers of fuzz targets that trace: a ray stored before the block's bytes, and a scene with the geometry of the
// blocks.

#include "fuzz_input.h"
#include "kernels/common/scene.h"
#include <embree3/rtcore.h>

namespace programs::test {

struct RayBytes {
  float org[3], tnear;
  float dir[3], tfar;
  float time, unused[3];

  embree::Ray ray() const {
    return embree::Ray(embree::Vec3fa(org[0], org[1], org[2]), embree::Vec3fa(dir[0], dir[1], dir[2]), tnear, tfar,
                       time);
  }

  // Removes the ray from the input. Returns false if fewer than `least` bytes follow.
  bool read(const uint8_t*& data, size_t& size, size_t least) {
    if (size < sizeof(*this) + least) return false;
    std::memcpy(this, data, sizeof(*this));
    data += sizeof(*this);
    size -= sizeof(*this);
    return true;
  }
};

// Geometry 0 of a scene. Epilogues read its mask and filters.
struct World {
  RTCScene scene;
  World() {
    RTCDevice device = rtcNewDevice("threads=1");
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_SUBDIVISION);
    scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcReleaseDevice(device);
  }
};

// Rays from above, along the surface, from inside and next to a block over the unit square.
const RayBytes seedRays[] = {{{0.4f, 0.6f, 3}, 0, {0.01f, -0.02f, -1}, INFINITY, 0.3f, {}},
                             {{-2, 0.5f, 0.1f}, 0, {1, 0.05f, 0.01f}, INFINITY, 0, {}},
                             {{0.3f, 0.2f, 0.1f}, 0.001f, {0.5f, 0.7f, 0.1f}, 5, 0.7f, {}},
                             {{0.5f, 3, -0.2f}, 0, {0, -1, 0}, 1e6f, 1, {}}};

// Writes a file of the corpus for each of these rays.
inline void writeSeedsWithRays(const std::string& path, const void* block, size_t bytes) {
  for (const RayBytes& ray : seedRays)
    writeSeed(path + "-" + std::to_string(&ray - seedRays),
              std::string((const char*)&ray, sizeof(ray)) + std::string((const char*)block, bytes));
}

} // namespace programs::test
