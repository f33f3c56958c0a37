// Copyright 2026 The Embree CBVH authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "support/moving_surface.h"
#include "support/random.h"
#include "validated_device.h"

namespace programs::test {

// A triangle at a height over a part of [-1,1]^2; committed, not attached.
inline RTCGeometry newTriangle(RTCDevice device, float z, unsigned timeSteps = 1) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetGeometryTimeStepCount(geometry, timeSteps);
  for (unsigned t = 0; t < timeSteps; t++)
    setBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, t, RTC_FORMAT_FLOAT3,
              std::vector<Vec>{{-1, -1, z}, {1, -1, z}, {-1, 1, z}});
  setBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, std::vector<std::array<unsigned, 3>>{{0, 1, 2}});
  rtcCommitGeometry(geometry);
  return geometry;
}

// A committed instance that is not attached.
inline RTCGeometry newInstance(RTCDevice device, RTCScene scene, float z, unsigned timeSteps = 1) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, scene);
  rtcSetGeometryTimeStepCount(geometry, timeSteps);
  const float transform[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, z};
  for (unsigned t = 0; t < timeSteps; t++)
    rtcSetGeometryTransform(geometry, t, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
  rtcCommitGeometry(geometry);
  return geometry;
}

// Settings of surfaces without displacement.
inline SurfaceSettings smallSurface(RTCCompression compression) {
  SurfaceSettings settings;
  settings.rate = 8;
  settings.compression = compression;
  settings.frameLevel = 1;
  return settings;
}

const RTCCompression allKinds[] = {RTC_COMPRESSION_NONE,  RTC_COMPRESSION_CGRID, RTC_COMPRESSION_CVOXEL,
                                   RTC_COMPRESSION_CLEAF, RTC_COMPRESSION_CVERT, RTC_COMPRESSION_CTILE};

// With a displacement that must outlive the surface.
inline SurfaceSettings displacedSettings(Displacement& displacement, RTCCompression compression, float rate) {
  SurfaceSettings settings;
  settings.displacement = &displacement;
  settings.compression = compression;
  settings.frameLevel = 1;
  settings.rate = rate;
  return settings;
}

// Side by side, each with its own bit of the mask. The displacements must outlive them.
inline void addSurfacesOfAllKinds(RTCDevice device, RTCScene scene, Displacement (&displacements)[6]) {
  for (unsigned i = 0; i < 6; i++) {
    displacements[i].offset = {0.8f * float(i) - 1.6f, 0.3f * float(i % 2), 0.2f * float(i % 3)};
    displacements[i].scale = 0.5f;
    SurfaceSettings settings = displacedSettings(displacements[i], allKinds[i], 16);
    settings.mask = 1u << i;
    addSurface(device, scene, i % 2 ? cubeCage() : prismCage(5), settings);
  }
}

// Rays for attachMovingInstances: at random times, half of them with random masks.
inline std::vector<RTCRayHit> maskedTimedRays(Random& random, unsigned count) {
  std::vector<RTCRayHit> rays = timedRays(random, count);
  for (size_t i = 0; i < rays.size(); i += 2) rays[i].ray.mask = unsigned(random.below(16));
  return rays;
}

// 30 instances with 1 to 4 time steps, some with a part of the time range, with one of four mask bits.
inline void attachMovingInstances(RTCDevice device, RTCScene scene, RTCScene inside, Random& random) {
  for (unsigned i = 0; i < 30; i++) {
    const unsigned timeSteps = 1 + i % 4;
    RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, inside);
    rtcSetGeometryTimeStepCount(instance, timeSteps);
    if (timeSteps > 1 && i % 3 == 0) rtcSetGeometryTimeRange(instance, 0.2f, 0.7f);
    float transform[12];
    // not nearly singular
    for (int k = 0; k < 9; k++) transform[k] = (k % 4 == 0 ? 0.35f : 0) + float(0.06 * random.normal());
    for (int k = 9; k < 12; k++) transform[k] = float(random.uniform(-1.2, 1.2));
    for (unsigned t = 0; t < timeSteps; t++) {
      for (float& x : transform) x += float(0.05 * random.normal());
      rtcSetGeometryTransform(instance, t, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
    }
    rtcSetGeometryMask(instance, 1u << (i % 4));
    rtcCommitGeometry(instance);
    attach(scene, instance);
  }
}

// Instances, static and moving, with a transform for which Embree leaves them out.
inline void attachInvalidInstances(RTCDevice device, RTCScene scene, RTCScene inside) {
  struct {
    int entry;
    float value;
  } changes[] = {{4, NAN}, {10, NAN}, {0, INFINITY}, {9, -INFINITY}, {8, 1e19f}, {11, 1e19f}, {3, 3e38f}};
  for (const auto& change : changes)
    for (unsigned timeSteps : {1u, 2u}) {
      RTCGeometry instance = newInstance(device, inside, 0, timeSteps);
      float transform[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
      transform[change.entry] = change.value;
      rtcSetGeometryTransform(instance, timeSteps - 1, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, transform);
      rtcCommitGeometry(instance);
      attach(scene, instance);
    }
}

// Geometry 0 is a compressed surface around z = 0; geometry 1 is a triangle at z = 1 above one half of it.
class SmallScene : public Scene {
public:
  explicit SmallScene(RTCDevice device, RTCCompression compression = RTC_COMPRESSION_CLEAF) : Scene(device) {
    addSurface(device, *this, sheetCage(2), smallSurface(compression));
    attach(*this, newTriangle(device, 1));
    rtcCommitScene(*this);
  }
};

// Rays from above: at the triangle, at the surface, and past both.
inline std::vector<RTCRayHit> raysFromAbove() {
  std::vector<RTCRayHit> rays;
  for (const Vec& org :
       {Vec{-0.5f, -0.4f, 5}, Vec{0.4f, 0.5f, 5}, Vec{7, 7, 5}, Vec{-0.6f, 0.2f, 5}, Vec{0.3f, 0.7f, 0.5f}})
    rays.push_back(makeRay(org, {0.01f, 0.02f, -1}));
  return rays;
}

inline std::vector<RTCRay> withoutHits(const std::vector<RTCRayHit>& rays) {
  std::vector<RTCRay> out;
  for (const RTCRayHit& ray : rays) out.push_back(ray.ray);
  return out;
}

// Compares bits.
template<typename Ray>
bool areSame(const std::vector<Ray>& a, const std::vector<Ray>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(Ray)) == 0);
}

// Replaces rays by their hits. Returns false on failure, with unchanged rays.
inline bool trace(RTCVulkanScene scene, std::vector<RTCRayHit>& rays, RTCVulkanTraceTimes* times = nullptr) {
  const RTCVulkanTrace trace = rtcStartVulkanIntersect(scene, rays.data(), rays.size());
  return trace && rtcFinishVulkanTrace(trace, rays.data(), times);
}
inline bool trace(RTCVulkanScene scene, std::vector<RTCRay>& rays, RTCVulkanTraceTimes* times = nullptr) {
  const RTCVulkanTrace trace = rtcStartVulkanOccluded(scene, rays.data(), rays.size());
  return trace && rtcFinishVulkanTrace(trace, rays.data(), times);
}

inline std::vector<RTCRayHit> traceAll(RTCVulkanScene scene, std::vector<RTCRayHit> rays) {
  EXPECT_TRUE(trace(scene, rays));
  return rays;
}

inline void expectAsOnTheCPU(RTCScene scene, const std::vector<RTCRayHit>& rays, const std::vector<RTCRayHit>& traced) {
  for (size_t i = 0; i < rays.size(); i++) {
    SCOPED_TRACE(testing::Message() << "ray " << i);
    const RTCRayHit expected = intersect(scene, rays[i]);
    EXPECT_EQ(expected.hit.geomID, traced[i].hit.geomID);
    EXPECT_EQ(expected.hit.instID[0], traced[i].hit.instID[0]);
    if (isHit(expected)) {
      EXPECT_EQ(expected.hit.primID, traced[i].hit.primID);
      EXPECT_NEAR(expected.ray.tfar, traced[i].ray.tfar, 1e-4f);
    } else {
      EXPECT_EQ(expected.ray.tfar, traced[i].ray.tfar);
    }
  }
}

} // namespace programs::test
